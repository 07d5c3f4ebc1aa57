// The failures of a disk, in the words of Result<T>.
#pragma once

#include <string>

#include "engine/result.h"

namespace meshgauge::server::store {

// "<what>: No space left on device", with the code that tells a full disk from one that cannot be used.
Error storage_error(int error_number, const std::string& what);

bool means_full(int error_number);  // of the disk, the user's quota or the largest file allowed

}  // namespace meshgauge::server::store
