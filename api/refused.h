// Constructors of the errors and problems that many places return.
#pragma once

#include <string>
#include <utility>

#include "api/problem.h"
#include "engine/result.h"

namespace meshgauge {

// Returns an Error of code invalid_request; `part` and `where` as in Error.
inline Error refused(std::string message, std::string part = "", std::string where = "") {
  return {ErrorCode::invalid_request, std::move(message), std::move(part), std::move(where)};
}

// Returns an invalid_request Error that names the flag in the message and in Error::where.
inline Error bad_flag(const std::string& flag, const std::string& why) { return refused(flag + ": " + why, "", flag); }

namespace api {

// Returns the problem of a request that cannot be parsed.
inline Problem malformed(std::string what) { return {ProblemKind::malformed_request, std::move(what), {}}; }

// Returns the problem of a path whose id no resource has. `kind`: the noun of the resource.
inline Problem not_found(const std::string& kind) {
  return {ProblemKind::not_found, "no " + kind + " has this id, or it is no longer stored", {}};
}

}  // namespace api
}  // namespace meshgauge
