#include "api/base/problem.h"

#include <nlohmann/json.hpp>

namespace meshgauge::api {
namespace {

constexpr ProblemRow kTable[] = {
    {ProblemKind::malformed_request, "malformed-request", "The request is malformed", 400},
    {ProblemKind::unauthorized, "unauthorized", "A key is needed", 401},
    {ProblemKind::forbidden, "forbidden", "The request needs a key that allows it", 403},
    {ProblemKind::foreign_request, "foreign-request", "The request is for or from another site", 403},
    {ProblemKind::quota_exceeded, "quota-exceeded", "The key's storage quota is used up", 403},
    {ProblemKind::not_found, "not-found", "Not found", 404},
    {ProblemKind::method_not_allowed, "method-not-allowed", "This path does not take this method", 405},
    {ProblemKind::request_timeout, "request-timeout", "The request arrived too slowly", 408},
    {ProblemKind::length_required, "length-required", "The length of the body is missing", 411},
    {ProblemKind::too_large, "too-large", "A size limit is exceeded", 413, ErrorCode::too_large},
    {ProblemKind::uri_too_long, "uri-too-long", "The request target is too long", 414},
    {ProblemKind::unsupported_media_type, "unsupported-media-type",
     "The body's media type or encoding is not supported", 415},
    {ProblemKind::head_too_large, "head-too-large", "The request's head is too large", 431},
    {ProblemKind::too_many_requests, "too-many-requests", "The key or the client's address is at its limit", 429},
    {ProblemKind::not_implemented, "not-implemented", "The method or transfer coding is not implemented", 501},
    {ProblemKind::http_version, "http-version", "The HTTP version is not supported", 505},
    {ProblemKind::digest_mismatch, "digest-mismatch", "The bytes do not have the SHA-256 of the path", 422},
    {ProblemKind::idempotency_key_reused, "idempotency-key-reused", "The Idempotency-Key was used for another request",
     422},
    {ProblemKind::unknown_mesh, "unknown-mesh", "A mesh of the comparison is not stored", 422},
    {ProblemKind::mesh_gone, "mesh-gone", "A mesh of the comparison is no longer stored", 410},
    {ProblemKind::no_interval, "no-interval", "The comparison has no interval", 409},
    {ProblemKind::not_ended, "not-ended", "The batch has not ended", 409},
    {ProblemKind::not_ready, "not-ready", "The service cannot take work", 503},
    {ProblemKind::storage_full, "storage-full", "The service's storage is full", 507, ErrorCode::storage_full},
    {ProblemKind::storage_unavailable, "storage-unavailable", "The service's storage is unavailable", 503,
     ErrorCode::storage_unavailable},
    {ProblemKind::overloaded, "overloaded", "The service is at its limit", 503},
    {ProblemKind::shutting_down, "shutting-down", "The service is shutting down", 503},
    {ProblemKind::invalid_request, "invalid-request", "The options are invalid", 422, ErrorCode::invalid_request},
    {ProblemKind::unit_conflict, "unit-conflict", "The units of the meshes and the limit do not fit", 422,
     ErrorCode::unit_conflict},
    {ProblemKind::unsupported_format, "unsupported-format", "The file format is not supported", 415,
     ErrorCode::unsupported_format},
    {ProblemKind::unreadable_mesh, "unreadable-mesh", "The mesh file is malformed", 422, ErrorCode::unreadable_mesh},
    {ProblemKind::empty_mesh, "empty-mesh", "The mesh has no triangles", 422, ErrorCode::empty_mesh},
    {ProblemKind::non_finite_vertex, "non-finite-vertex", "A coordinate is NaN or infinite", 422,
     ErrorCode::non_finite_vertex},
    {ProblemKind::index_out_of_range, "index-out-of-range", "A face names a vertex that does not exist", 422,
     ErrorCode::index_out_of_range},
    {ProblemKind::coordinate_too_large, "coordinate-too-large", "A coordinate is too large to measure", 422,
     ErrorCode::coordinate_too_large},
    {ProblemKind::out_of_time, "out-of-time", "The deadline passed before there was a result", 503,
     ErrorCode::out_of_time},
    {ProblemKind::cancelled, "cancelled", "The comparison was cancelled", 409},
    {ProblemKind::internal, "internal", "The service failed", 500, ErrorCode::internal},
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

std::string Problem::type() const { return "urn:meshgauge:problem:" + std::string(row_of(kind).slug); }

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
