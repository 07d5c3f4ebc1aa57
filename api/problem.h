// RFC 9457 problem documents: the one shape of every answer that is not a result.
//
//   {"type": "urn:meshgauge:problem:unreadable-mesh", "title", "status", "detail", "errors": [{"part", "where",
//   "message"}]}
//
// `type` is stable; openapi.yaml lists the same kinds.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"

namespace meshgauge::api {

enum class ProblemKind {
  malformed_request,  // not HTTP, not multipart, a part missing, unknown or twice
  unauthorized,       // no key, or not one that counts
  forbidden,          // the key's scopes do not allow this
  quota_exceeded,     // of what the key may store
  not_found,
  method_not_allowed,
  request_timeout,  // the head or the body came too slowly
  length_required,
  too_large,
  uri_too_long,
  unsupported_media_type,  // of the request: Content-Type, Content-Encoding
  head_too_large,
  too_many_requests,  // of one key: its rate, or its jobs at the same time; or of one client's address
  not_implemented,    // a method or transfer coding that is not known here
  http_version,
  digest_mismatch,         // the bytes are not those that their name says
  idempotency_key_reused,  // with another request
  unknown_mesh,            // a comparison names one that is not stored
  mesh_gone,               // a comparison had one that is not kept any more
  no_interval,             // the comparison has not ended, or has none
  not_ended,               // a batch, that is told of when it has
  not_ready,
  storage_full,
  storage_unavailable,
  overloaded,  // the queue, the connections or the bytes of all uploads are at their limit
  shutting_down,
  invalid_request,
  unsupported_format,
  unreadable_mesh,
  empty_mesh,
  non_finite_vertex,
  index_out_of_range,
  coordinate_too_large,
  out_of_time,
  cancelled,  // a comparison, by its owner, before there was an interval to give
  internal,
};

struct ProblemRow {
  ProblemKind kind;
  std::string_view slug;  // ends the type URN
  std::string_view title;
  int status;                                    // HTTP
  std::optional<ErrorCode> code = std::nullopt;  // the Error that becomes this problem; each code in one row
};

std::span<const ProblemRow> problem_table();  // every kind, once

struct ProblemItem {
  std::string part;  // "a", "b", "options"; may be empty
  std::string where;
  std::string message;
};

struct Problem {
  ProblemKind kind = ProblemKind::internal;
  std::string detail;
  std::vector<ProblemItem> errors;

  int status() const;
  std::string type() const;
};

Problem to_problem(const Error& error);

// Any bytes may stand in the strings: what is not UTF-8 becomes U+FFFD.
std::string to_json(const Problem& problem);

}  // namespace meshgauge::api
