// The two uses of OpenSSL: names for bytes, and names nobody can guess.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace meshgauge::api {

std::string sha256_hex(std::span<const std::byte> bytes);  // 64 lower-case hex digits

std::string random_id();  // 128 bits from the system's generator, 32 lower-case hex digits; throws when it fails

}  // namespace meshgauge::api
