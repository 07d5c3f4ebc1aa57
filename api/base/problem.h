// RFC 9457 problem documents: the body of every answer that is not a result.
//
//   {"type": "/problems/unreadable-mesh", "title", "status", "detail", "errors": [{"part", "where", "message"}]}
//
// `type` is stable, and the address of a page of the service about it. openapi.yaml lists the same kinds.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/result.h"

namespace meshgauge::api {

enum class ProblemKind {
  malformed_request,  // not HTTP, not multipart, or a part that is missing, unknown or repeated
  unauthorized,       // no key, or one that is unknown, disabled or expired
  forbidden,          // the key lacks the scope
  foreign_request,    // without keys: a page of another site sent it, or it names another host
  quota_exceeded,     // the key's storage quota is used up
  not_found,
  method_not_allowed,
  request_timeout,  // the head or the body arrived too slowly
  length_required,
  too_large,
  uri_too_long,
  unsupported_media_type,  // the request's Content-Type or Content-Encoding
  head_too_large,
  too_many_requests,  // a limit of one key (rate, jobs at a time) or of one client address
  not_implemented,    // an unknown method or transfer coding
  http_version,
  digest_mismatch,         // the bytes do not have the SHA-256 of the path
  idempotency_key_reused,  // sent before with a different request
  unknown_mesh,            // a comparison names a mesh that is not stored
  mesh_gone,               // a mesh of the comparison is no longer stored
  no_interval,             // the comparison has not ended or has no interval
  not_ended,               // the batch has not ended, so it has no report
  not_ready,
  storage_full,
  storage_unavailable,
  overloaded,  // the queue, the connections or the total upload bytes are at their limit
  shutting_down,
  invalid_request,
  unit_conflict,  // one mesh's unit is unknown, or a limit without unit for meshes of different units
  unsupported_format,
  unreadable_mesh,
  empty_mesh,
  non_finite_vertex,
  index_out_of_range,
  coordinate_too_large,
  out_of_time,
  cancelled,  // the owner cancelled the comparison before it had an interval
  internal,
};

struct ProblemRow {
  ProblemKind kind;
  std::string_view slug;  // last component of the type
  std::string_view title;
  int status;                                    // HTTP
  std::string_view help;                         // what it means and what to do, in sentences that are plain in HTML
  std::optional<ErrorCode> code = std::nullopt;  // Errors of this code become this problem; each code is in one row
};

inline constexpr std::string_view kProblemFolder = "/problems/";

// Returns "unreadable-mesh" of "/problems/unreadable-mesh", and of "urn:meshgauge:problem:unreadable-mesh", which jobs
// that version 0.1 stored have. Empty: it is no type of a problem.
std::string_view slug_of(std::string_view type);

std::span<const ProblemRow> problem_table();  // every kind once

struct ProblemItem {
  std::string part;  // "a", "b", "options"; may be empty
  std::string where;
  std::string message;
};

struct Problem {
  ProblemKind kind = ProblemKind::internal;
  std::string detail;
  std::vector<ProblemItem> errors{};

  int status() const;
  std::string type() const;
};

Problem to_problem(const Error& error);

// Returns the problem of a request that cannot be parsed.
inline Problem malformed(std::string what) { return {ProblemKind::malformed_request, std::move(what)}; }

// Returns the problem of a path whose id no resource has. `kind`: the noun of the resource.
inline Problem not_found(const std::string& kind) {
  return {ProblemKind::not_found, "no " + kind + " has this id, or it is no longer stored"};
}

// Serialises a problem. Invalid UTF-8 in its strings becomes U+FFFD.
std::string to_json(const Problem& problem);

}  // namespace meshgauge::api
