#include "server/meshes.h"

#include <nlohmann/json.hpp>

#include "api/digest.h"
#include "api/request.h"
#include "server/jobs/job_document.h"
#include "server/parameters.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using store::BlobKey;
using store::MeshRow;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostNameBytes = 255;

Problem not_found() { return {ProblemKind::not_found, "there is no mesh of this id, or not any more", {}}; }

Problem over_quota(std::uint64_t most) {
  return {ProblemKind::quota_exceeded,
          "the stored meshes would be larger than the limit of " + std::to_string(most) + " bytes; delete some", {}};
}

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

std::string to_json(const MeshRow& row) {
  const Json json{{"id", row.key.id},
                  {"bytes", row.bytes},
                  {"media_type", text_or_null(row.media_type)},
                  {"file_name", text_or_null(row.file_name)},
                  {"created", to_text(row.created)},
                  {"last_used", to_text(row.last_used)},
                  {"expires", to_text(row.expires)}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<Problem> check_id(const Exchange& exchange) {
  if (api::is_mesh_id(exchange.segment)) return std::nullopt;
  return Problem{ProblemKind::malformed_request, "a mesh is named by its SHA-256: 64 lower-case hex digits", {}};
}

std::string file_name(const Head& head) {
  std::string_view disposition = head.header("content-disposition");
  take_kind(disposition);
  std::string found;
  for_each_parameter(disposition, [&](const std::string& name, const std::string& value) {
    if (name == "filename") found = value.substr(0, kMostNameBytes);
  });
  return found;
}

}  // namespace

Meshes::Meshes(const Settings& settings, store::MeshIndex& index, store::BlobStore& blobs)
    : settings_(settings), index_(index), blobs_(blobs), budget_(settings.max_upload_bytes) {}

void Meshes::put(Exchange& exchange) {
  if (auto refusal = check_id(exchange)) return answer(exchange, *refusal);
  const auto known = index_.get_mesh({exchange.owner, exchange.segment});
  if (!known) return answer(exchange, api::to_problem(known.error()));
  Upload upload(budget_, settings_.temp_dir);
  if (auto refusal = receive(exchange, *known ? 0 : exchange.head.content_length.value_or(0), upload)) {
    return answer(exchange, *refusal);
  }
  keep(exchange, exchange.segment, upload);
}

void Meshes::post(Exchange& exchange) {
  Upload upload(budget_, settings_.temp_dir);
  if (auto refusal = receive(exchange, exchange.head.content_length.value_or(0), upload)) {
    return answer(exchange, *refusal);
  }
  keep(exchange, api::sha256_hex(upload.bytes()), upload);
}

std::optional<Problem> Meshes::receive(Exchange& exchange, std::uint64_t new_bytes, Upload& upload) const {
  if (auto refusal = refuse_query(exchange)) return refusal;
  if (auto refusal = check_quota(exchange.owner, new_bytes)) return refusal;
  const auto refusal = exchange.body.read([&](std::string_view piece) -> std::optional<Problem> {
    if (upload.size() + piece.size() <= settings_.max_part_bytes) return upload.append(piece);
    return Problem{ProblemKind::too_large,
                   "the mesh is larger than the limit of " + std::to_string(settings_.max_part_bytes) + " bytes", {}};
  });
  if (refusal) return refusal;
  if (upload.size() == 0) return Problem{ProblemKind::malformed_request, "the body is empty: it is the mesh file", {}};
  return upload.finish();
}

// Before the body is read; put_mesh() has the last word.
std::optional<Problem> Meshes::check_quota(const std::string& owner, std::uint64_t more) const {
  const auto stored = index_.stored_bytes(owner);
  if (!stored) return api::to_problem(stored.error());
  const std::uint64_t most = settings_.max_stored_bytes;
  if (more == 0 || (*stored <= most && more <= most - *stored)) return std::nullopt;
  return over_quota(most);
}

// The bytes come before the row, so that a row is never without them.
void Meshes::keep(Exchange& exchange, const std::string& id, const Upload& upload) {
  const BlobKey key{exchange.owner, id};
  const auto blob = blobs_.put(key, upload.bytes());
  if (!blob) return answer(exchange, api::to_problem(blob.error()));
  if (*blob == store::BlobPut::other_digest) {
    return answer(exchange, {ProblemKind::digest_mismatch,
                             "the body's SHA-256 is " + api::sha256_hex(upload.bytes()) + ", not that of the path", {}});
  }
  const auto now = store::now();
  const auto row = index_.put_mesh({key, upload.size(), std::string(exchange.head.header("content-type")),
                                    file_name(exchange.head), now, now, now + std::chrono::seconds(settings_.mesh_ttl_s)},
                                   settings_.max_stored_bytes);
  if (!row) return answer(exchange, api::to_problem(row.error()));
  if (row->what == store::MeshPut::over_quota) return answer(exchange, over_quota(settings_.max_stored_bytes));
  exchange.response.status = row->what == store::MeshPut::created ? 201 : 200;
  exchange.response.content_type = "application/json";
  exchange.response.body = to_json(row->row);
  exchange.response.headers.emplace_back("Location", "/v1/meshes/" + id);
}

void Meshes::get(Exchange& exchange) {
  if (auto refusal = check_id(exchange)) return answer(exchange, *refusal);
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  const auto row = index_.get_mesh({exchange.owner, exchange.segment});
  if (!row) return answer(exchange, api::to_problem(row.error()));
  if (!*row) return answer(exchange, not_found());
  exchange.response.content_type = "application/json";
  exchange.response.body = to_json(**row);
}

void Meshes::remove(Exchange& exchange) {
  if (auto refusal = check_id(exchange)) return answer(exchange, *refusal);
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  const auto removed = index_.delete_mesh({exchange.owner, exchange.segment});
  if (!removed) return answer(exchange, api::to_problem(removed.error()));
  if (!*removed) return answer(exchange, not_found());
  exchange.response.status = 204;
}

}  // namespace meshgauge::server
