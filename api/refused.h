// Refusals that many places give, made here alone.
#pragma once

#include <string>
#include <utility>

#include "api/problem.h"
#include "engine/result.h"

namespace meshgauge {

// Of code invalid_request; `part` and `where` as in Error.
inline Error refused(std::string message, std::string part = "", std::string where = "") {
  return {ErrorCode::invalid_request, std::move(message), std::move(part), std::move(where)};
}

// Of code invalid_request: names the flag in the message and as the place.
inline Error bad_flag(const std::string& flag, const std::string& why) { return refused(flag + ": " + why, "", flag); }

namespace api {

// No resource has the id of the path; `kind` is its noun.
inline Problem not_found(const std::string& kind) {
  return {ProblemKind::not_found, "there is no " + kind + " of this id, or not any more", {}};
}

}  // namespace api
}  // namespace meshgauge
