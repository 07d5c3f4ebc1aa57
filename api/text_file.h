// Reads small text files, such as settings and manifests.
#pragma once

#include <cstddef>
#include <string>

#include "engine/result.h"

namespace meshgauge::api {

// Returns the whole file. Error: invalid_request when it cannot be read or has more than `max_bytes`; the message does
// not name the file.
Result<std::string> read_text_file(const std::string& file, std::size_t max_bytes);

}  // namespace meshgauge::api
