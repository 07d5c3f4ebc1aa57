// A small file that an operator or a user wrote, as a whole.
#pragma once

#include <cstddef>
#include <string>

#include "engine/result.h"

namespace meshgauge::api {

Result<std::string> read_text_file(const std::string& file, std::size_t max_bytes);  // the message says why, not which

}  // namespace meshgauge::api
