// The program meshgauge_reader of the same build.
#pragma once

#include <cstddef>
#include <span>

namespace meshgauge::server::sandbox {

std::span<const std::byte> reader_image();  // empty if the build could not make it

}  // namespace meshgauge::server::sandbox
