#include "api/base/problem.h"

#include <nlohmann/json.hpp>

namespace meshgauge::api {
namespace {

constexpr ProblemRow kTable[] = {
    {ProblemKind::malformed_request, "malformed-request", "The request is malformed", 400,
     "The request is not HTTP, not multipart/form-data, or a part, a header or a query is missing, unknown or "
     "repeated. Correct the request: sent again as it is, it gets the same answer."},
    {ProblemKind::unauthorized, "unauthorized", "A key is needed", 401,
     "The service needs a key, and the request has none, or one that is unknown, disabled or expired. Send the header "
     "Authorization with 'Bearer' and the token of the key."},
    {ProblemKind::forbidden, "forbidden", "The request needs a key that allows it", 403,
     "The key is known, but its scopes do not allow this request. Use a key with the scope that the answer names."},
    {ProblemKind::foreign_request, "foreign-request", "The request is for or from another site", 403,
     "The service runs without keys, and a page of another site sent the request, or it names another host than the "
     "service's. Add the origin to --cors-origins, or the name to --allowed-hosts."},
    {ProblemKind::quota_exceeded, "quota-exceeded", "The key's storage quota is used up", 403,
     "What the key stores would exceed its limit. Delete stored meshes that are no longer needed."},
    {ProblemKind::not_found, "not-found", "Not found", 404,
     "Nothing has this path or this id: it never existed, was deleted, or was kept for its time and then removed."},
    {ProblemKind::method_not_allowed, "method-not-allowed", "This path does not take this method", 405,
     "The path exists and takes other methods, which the header Allow lists."},
    {ProblemKind::request_timeout, "request-timeout", "The request arrived too slowly", 408,
     "The head or the body of the request arrived too slowly. Send it again over a faster connection."},
    {ProblemKind::length_required, "length-required", "The length of the body is missing", 411,
     "The request has a body and does not say how long it is. Send Content-Length, or Transfer-Encoding: chunked."},
    {ProblemKind::too_large, "too-large", "A size limit is exceeded", 413,
     "A file, the body or a count exceeds a limit of the service, which the answer names.", ErrorCode::too_large},
    {ProblemKind::uri_too_long, "uri-too-long", "The request target is too long", 414,
     "The target of the request is longer than the service reads."},
    {ProblemKind::unsupported_media_type, "unsupported-media-type",
     "The body's media type or encoding is not supported", 415,
     "The Content-Type or the Content-Encoding of the request is none that this path takes."},
    {ProblemKind::head_too_large, "head-too-large", "The request's head is too large", 431,
     "The request has too many headers, or headers that are too long."},
    {ProblemKind::too_many_requests, "too-many-requests", "The key or the client's address is at its limit", 429,
     "The key or the client's address has sent too many requests, or has too many comparisons at a time. Send it "
     "again after the seconds that the header Retry-After names."},
    {ProblemKind::not_implemented, "not-implemented", "The method or transfer coding is not implemented", 501,
     "The service does not know the method or the transfer coding."},
    {ProblemKind::http_version, "http-version", "The HTTP version is not supported", 505,
     "The service speaks HTTP/1.1 and HTTP/1.0, and sends events over HTTP/1.1 alone."},
    {ProblemKind::digest_mismatch, "digest-mismatch", "The bytes do not have the SHA-256 of the path", 422,
     "The bytes that were sent do not have the SHA-256 that the path names. Compute the digest of the bytes as they "
     "are sent."},
    {ProblemKind::idempotency_key_reused, "idempotency-key-reused", "The Idempotency-Key was used for another request",
     422, "An earlier request with this Idempotency-Key was a different one. Take a new key for a new request."},
    {ProblemKind::unknown_mesh, "unknown-mesh", "A mesh of the comparison is not stored", 422,
     "The comparison names a mesh that is not stored here. Store it first: PUT /v1/meshes/ and its SHA-256."},
    {ProblemKind::mesh_gone, "mesh-gone", "A mesh of the comparison is no longer stored", 410,
     "A mesh of the comparison was deleted, or its time was over. Store it again."},
    {ProblemKind::no_interval, "no-interval", "The comparison has no interval", 409,
     "The comparison has not ended, or it ended without an interval, so there is nothing to show of it."},
    {ProblemKind::not_ended, "not-ended", "The batch has not ended", 409,
     "The batch has not ended, so it has no report yet. Ask again when it has."},
    {ProblemKind::not_ready, "not-ready", "The service cannot take work", 503,
     "The service runs and can take no work now. The answer names the component. Send the request again later."},
    {ProblemKind::storage_full, "storage-full", "The service's storage is full", 507,
     "The disk or the store of the service is full. Send the request again when there is room.",
     ErrorCode::storage_full},
    {ProblemKind::storage_unavailable, "storage-unavailable", "The service's storage is unavailable", 503,
     "The service does not reach its database or its store. Send the request again in a moment.",
     ErrorCode::storage_unavailable},
    {ProblemKind::overloaded, "overloaded", "The service is at its limit", 503,
     "The queue, the connections or the uploads of the service are at their limit. Send the request again after the "
     "seconds that the header Retry-After names."},
    {ProblemKind::shutting_down, "shutting-down", "The service is shutting down", 503,
     "This process of the service is stopping. Send the request again: another one may answer."},
    {ProblemKind::invalid_request, "invalid-request", "The options are invalid", 422,
     "An option has a value that it cannot have, or one that does not fit another option. The answer names each by a "
     "JSON pointer.",
     ErrorCode::invalid_request},
    {ProblemKind::unit_conflict, "unit-conflict", "The units of the meshes and the limit do not fit", 422,
     "A limit has a unit and a mesh has none that is known, or the meshes have different units and the limit has "
     "none. Say the units in the options.",
     ErrorCode::unit_conflict},
    {ProblemKind::unsupported_format, "unsupported-format", "The file format is not supported", 415,
     "The file is no mesh, or one of a format or a kind that is not read. Export it as OBJ, STL, PLY, OFF, glTF, GLB "
     "or 3MF.",
     ErrorCode::unsupported_format},
    {ProblemKind::unreadable_mesh, "unreadable-mesh", "The mesh file is malformed", 422,
     "The file begins like a known format and does not follow it: it is damaged or cut, or its writer has a defect. "
     "The answer names the line or the byte. Write the file again.",
     ErrorCode::unreadable_mesh},
    {ProblemKind::empty_mesh, "empty-mesh", "The mesh has no triangles", 422,
     "The file has no triangles, so there is no surface to measure.", ErrorCode::empty_mesh},
    {ProblemKind::non_finite_vertex, "non-finite-vertex", "A coordinate is NaN or infinite", 422,
     "A coordinate is NaN or infinite, or too large for a number of double precision. The answer names it.",
     ErrorCode::non_finite_vertex},
    {ProblemKind::index_out_of_range, "index-out-of-range", "A face names a vertex that does not exist", 422,
     "A face names a vertex that the file does not have. The answer names the place.", ErrorCode::index_out_of_range},
    {ProblemKind::coordinate_too_large, "coordinate-too-large", "A coordinate is too large to measure", 422,
     "A coordinate is beyond 2^1020, where distances cannot be computed. Write the file in a larger unit.",
     ErrorCode::coordinate_too_large},
    {ProblemKind::out_of_time, "out-of-time", "The deadline passed before there was a result", 503,
     "The time of the request was over before there was an interval. Give it more time, by the option timeout.",
     ErrorCode::out_of_time},
    {ProblemKind::cancelled, "cancelled", "The comparison was cancelled", 409,
     "The comparison was cancelled before it had an interval."},
    {ProblemKind::internal, "internal", "The service failed", 500,
     "The service failed, by a defect of its own. Its log has the cause under the X-Request-Id of the answer.",
     ErrorCode::internal},
};

const ProblemRow& row_of(ProblemKind kind) {
  for (const ProblemRow& row : kTable) {
    if (row.kind == kind) return row;
  }
  return std::end(kTable)[-1];
}

ProblemKind kind_of(ErrorCode code) {
  if (code == ErrorCode::storage_damaged) return ProblemKind::storage_unavailable;  // to clients there is no difference
  for (const ProblemRow& row : kTable) {
    if (row.code == code) return row.kind;
  }
  return ProblemKind::internal;
}

}  // namespace

std::span<const ProblemRow> problem_table() { return kTable; }

int Problem::status() const { return row_of(kind).status; }

std::string Problem::type() const { return std::string(kProblemFolder) + std::string(row_of(kind).slug); }

std::string_view slug_of(std::string_view type) {
  for (const std::string_view prefix : {kProblemFolder, std::string_view("urn:meshgauge:problem:")}) {
    if (type.starts_with(prefix)) return type.substr(prefix.size());
  }
  return {};
}

Problem to_problem(const Error& error) {
  Problem problem{kind_of(error.code), error.message};
  if (!error.part.empty() || !error.where.empty()) problem.errors = {{error.part, error.where, error.message}};
  for (const Error& other : error.others) problem.errors.push_back({other.part, other.where, other.message});
  return problem;
}

std::string to_json(const Problem& problem) {
  nlohmann::ordered_json json{{"type", problem.type()},
                              {"title", row_of(problem.kind).title},
                              {"status", problem.status()},
                              {"detail", problem.detail},
                              {"errors", nlohmann::ordered_json::array()}};
  for (const ProblemItem& item : problem.errors) {
    json["errors"].push_back({{"part", item.part}, {"where", item.where}, {"message", item.message}});
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace meshgauge::api
