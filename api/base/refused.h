// Constructors of the Errors of code invalid_request, which many places return.
#pragma once

#include <string>
#include <utility>

#include "engine/result.h"

namespace meshgauge {

// Returns an Error of code invalid_request; `part` and `where` as in Error.
inline Error refused(std::string message, std::string part = "", std::string where = "") {
  return {ErrorCode::invalid_request, std::move(message), std::move(part), std::move(where)};
}

// Returns an invalid_request Error that names the flag in the message and in Error::where.
inline Error bad_flag(const std::string& flag, const std::string& why) { return refused(flag + ": " + why, "", flag); }

}  // namespace meshgauge
