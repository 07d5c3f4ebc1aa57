// Failures of a disk as Error.
#pragma once

#include <string>

#include "engine/result.h"

namespace meshgauge::server::store {

// "<what>: No space left on device", with storage_full or storage_unavailable.
Error storage_error(int error_number, const std::string& what);

bool means_full(int error_number);  // the disk, the user's quota or the limit on file size

}  // namespace meshgauge::server::store
