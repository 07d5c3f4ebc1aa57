// The program meshgauge_reader as the same build made it.
#pragma once

#include <cstddef>
#include <span>

namespace meshgauge::server::sandbox {

std::span<const std::byte> reader_image();  // empty when the build could make none

}  // namespace meshgauge::server::sandbox
