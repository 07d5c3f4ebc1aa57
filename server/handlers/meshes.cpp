#include "server/handlers/meshes.h"

#include <nlohmann/json.hpp>

#include "api/base/digest.h"
#include "api/base/problem.h"
#include "api/options/batch_request.h"
#include "server/access/entrance.h"
#include "server/handlers/job_document.h"
#include "server/http/head_values.h"

namespace meshgauge::server {
namespace {

using api::Json;
using api::malformed;
using api::not_found;
using api::Problem;
using api::ProblemKind;
using api::text_or_null;
using store::BlobKey;
using store::MeshRow;

constexpr std::size_t kMostNameBytes = 255;

Problem over_quota(std::uint64_t most) {
  return {ProblemKind::quota_exceeded,
          "the stored meshes would exceed the limit of " + std::to_string(most) + " bytes; delete some"};
}

Problem too_many_meshes(std::uint64_t most) {
  return {ProblemKind::quota_exceeded,
          "the stored meshes would be more than the limit of " + std::to_string(most) + "; delete some"};
}

std::string to_json(const MeshRow& row) { return mesh_json(row).dump(-1, ' ', false, Json::error_handler_t::replace); }

std::optional<Problem> check_id(const Exchange& exchange) {
  if (api::is_mesh_id(exchange.segment)) return std::nullopt;
  return malformed("the id of a mesh must be its SHA-256, 64 lower-case hex digits");
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

Json mesh_json(const MeshRow& row) {
  return {{"id", row.key.id},
          {"bytes", row.bytes},
          {"media_type", text_or_null(row.media_type)},
          {"file_name", text_or_null(row.file_name)},
          {"created", to_text(row.created)},
          {"last_used", to_text(row.last_used)},
          {"expires", to_text(row.expires)}};
}

Meshes::Meshes(const Settings& settings, const Stores& stores, Access& access, ByteBudget& uploads)
    : settings_(settings), stores_(stores), access_(access), uploads_(uploads) {}

void Meshes::put(Exchange& exchange) {
  if (auto refusal = check_id(exchange)) return answer(exchange, *refusal);
  const auto there = stores_.blobs.exists({exchange.owner, exchange.segment});
  if (!there) return answer(exchange, api::to_problem(there.error()));
  receive(exchange, *there ? 0 : exchange.head.content_length.value_or(0), exchange.segment);
}

void Meshes::post(Exchange& exchange) { receive(exchange, exchange.head.content_length.value_or(0), ""); }

// `id`: from the path; empty: it is to be computed.
void Meshes::receive(Exchange& exchange, std::uint64_t new_bytes, const std::string& id) {
  auto room = hold_room(exchange.owner, new_bytes);
  if (const auto* denial = std::get_if<Denial>(&room)) return answer(exchange, *denial);
  const auto held = std::make_shared<const StorageHold>(std::get<StorageHold>(std::move(room)));
  const auto upload = std::make_shared<Upload>(UploadShare(uploads_, client_of(exchange)), settings_.temp_dir);
  const auto add = [this, upload](std::string_view piece) -> std::optional<Problem> {
    if (upload->size() + piece.size() <= settings_.max_part_bytes) return upload->append(piece);
    return Problem{ProblemKind::too_large,
                   "the mesh is larger than the limit of " + std::to_string(settings_.max_part_bytes) + " bytes"};
  };
  exchange.body.read(add, [this, &exchange, upload, id, hold = held](auto refusal) mutable {
    if (!refusal && upload->size() == 0) {
      refusal = malformed("the body is empty; send the mesh file as the body");
    }
    if (!refusal) refusal = upload->finish();
    hold.reset();  // the bytes are counted again when they are stored
    if (refusal) return answer(exchange, *refusal);
    keep(exchange, id.empty() ? api::sha256_hex(upload->bytes()) : id, *upload);
  });
}

std::variant<StorageHold, Denial> Meshes::hold_room(const std::string& owner, std::uint64_t more) const {
  return hold_storage(access_, stores_, owner, more == 0 ? 0 : more + kMeshOverhead, settings_.max_stored_bytes);
}

void Meshes::keep(Exchange& exchange, const std::string& id, const Upload& upload) {
  const BlobKey key{exchange.owner, id};
  {
    const auto reserved = stores_.blobs.reserve(key);
    store(exchange, key, upload);
  }
  if (!exchange.problem.empty()) discard(key);
}

// Stores the bytes before the row, so that no row is without its bytes.
void Meshes::store(Exchange& exchange, const BlobKey& key, const Upload& upload) {
  const auto there = stores_.blobs.exists(key);
  if (!there) return answer(exchange, api::to_problem(there.error()));
  const auto room = hold_room(exchange.owner, *there ? 0 : upload.size());
  if (const auto* denial = std::get_if<Denial>(&room)) return answer(exchange, *denial);
  const auto blob = stores_.blobs.put(key, upload.bytes());
  if (!blob) return answer(exchange, api::to_problem(blob.error()));
  if (*blob == store::BlobPut::other_digest) {
    return answer(exchange,
                  Problem{ProblemKind::digest_mismatch,
                          "the body's SHA-256 is " + api::sha256_hex(upload.bytes()) + ", not that of the path"});
  }
  const auto now = stores_.jobs.time();
  const auto row = stores_.meshes.put_mesh(
      {key, upload.size(), std::string(exchange.head.header("content-type").substr(0, kMostNameBytes)),
       file_name(exchange.head), now, now, now + std::chrono::seconds(settings_.mesh_ttl_s)},
      {settings_.max_stored_bytes, settings_.max_stored_meshes});
  if (!row) return answer(exchange, api::to_problem(row.error()));
  if (row->what == store::MeshPut::over_quota) return answer(exchange, over_quota(settings_.max_stored_bytes));
  if (row->what == store::MeshPut::too_many) return answer(exchange, too_many_meshes(settings_.max_stored_meshes));
  answer_with(exchange, to_json(row->row), row->what == store::MeshPut::created ? 201 : 200);
  exchange.response.headers.emplace_back("Location", "/v1/meshes/" + key.id);
}

void Meshes::discard(const BlobKey& key) const {
  const auto removed = remove_if_unreferenced(stores_, key);
  static_cast<void>(removed);  // a sweep removes what this could not
}

void Meshes::get(Exchange& exchange) {
  if (auto refusal = check_id(exchange)) return answer(exchange, *refusal);
  const auto row = stores_.meshes.get_mesh({exchange.owner, exchange.segment});
  if (!row) return answer(exchange, api::to_problem(row.error()));
  if (!*row) return answer(exchange, not_found("mesh"));
  answer_with(exchange, to_json(**row));
}

void Meshes::remove(Exchange& exchange) {
  if (auto refusal = check_id(exchange)) return answer(exchange, *refusal);
  const BlobKey key{exchange.owner, exchange.segment};
  const auto removed = stores_.meshes.delete_mesh(key);
  if (!removed) return answer(exchange, api::to_problem(removed.error()));
  if (!*removed) return answer(exchange, not_found("mesh"));
  stores_.cache.forget(key.owner, key.id);
  discard(key);
  // After the bytes are gone, so that a map started from here on does not find them.
  if (stores_.maps) stores_.maps->forget_mesh(key.owner, key.id);
  exchange.response.status = 204;
}

}  // namespace meshgauge::server
