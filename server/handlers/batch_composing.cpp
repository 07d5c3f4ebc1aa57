#include "server/handlers/batch_composing.h"

#include <algorithm>
#include <set>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "api/digest.h"
#include "server/measure/equal_work.h"
#include "server/measure/mesh_source.h"

namespace meshgauge::server {
namespace {

constexpr std::size_t kMostErrors = 100;

// What a job's row says of a mesh.
struct Named {
  std::string id;
  std::uint64_t bytes = 0;
  std::string file_name;
  std::string media_type;
};

class NamedMeshes {
 public:
  NamedMeshes(const std::map<std::string, BatchFile>& files, const std::vector<store::MeshRow>& known) : files_(files) {
    for (const store::MeshRow& row : known) rows_.emplace(row.key.id, &row);
  }

  Named operator()(const api::BatchMesh& mesh) const {
    if (!mesh.part.empty()) {
      const BatchFile& file = files_.at(mesh.part);
      return {file.id, file.bytes, file.file_name, file.media_type};
    }
    const auto found = rows_.find(mesh.id);
    if (found == rows_.end()) return {mesh.id, 0, "", ""};
    const store::MeshRow& row = *found->second;
    return {row.key.id, row.bytes, row.file_name, row.media_type};
  }

 private:
  const std::map<std::string, BatchFile>& files_;
  std::unordered_map<std::string, const store::MeshRow*> rows_;
};

MeshSource source_of(const std::string& part, const Named& mesh) {
  return {{part, {}, mesh.file_name, mesh.media_type, -1}, nullptr, mesh.id, {}};
}

store::BatchItem item_of(const BatchHead& head, const api::BatchPair& pair, const std::string& options, const Named& a,
                         const Named& b) {
  store::BatchItem item;
  item.name = pair.name;
  store::NewJob& job = item.job;
  job.key = {head.key.owner, api::random_id()};
  job.mesh_a = a.id;
  job.mesh_b = b.id;
  job.hints = hints_of(source_of("a", a), source_of("b", b));
  job.options = options;
  job.cost = a.bytes + b.bytes;
  job.trace = head.trace;
  job.batch = head.key.id;
  job.client = head.client;
  job.created = head.created;
  job.expires_if_never_run = head.expires_if_never_run;
  item.work = work_of(job);
  return item;
}

// A digest of the request alone, not of its meshes' rows: these may be gone when the request is repeated.
std::string fingerprint_of(const api::BatchRequest& request, const store::NewBatch& batch) {
  api::Sha256 all;
  const auto add = [&](const std::string& text) {
    const std::string framed = std::to_string(text.size()) + ":" + text;
    all.update(std::as_bytes(std::span(framed)));
  };
  add(request.name);
  for (const store::BatchItem& item : batch.items) {
    for (const std::string* text : {&item.name, &item.job.mesh_a, &item.job.mesh_b, &item.job.options}) add(*text);
  }
  return all.hex();
}

}  // namespace

std::vector<std::string> stored_ids(const api::BatchRequest& request) {
  std::set<std::string> ids;
  for (const api::BatchPair& pair : request.pairs) {
    for (const api::BatchMesh* mesh : {&pair.a, &pair.b}) {
      if (!mesh->id.empty()) ids.insert(mesh->id);
    }
  }
  return {ids.begin(), ids.end()};
}

std::optional<api::Problem> find_unknown(const api::BatchRequest& request, const std::vector<store::MeshRow>& known) {
  std::unordered_set<std::string> ids;
  for (const store::MeshRow& row : known) ids.insert(row.key.id);
  api::Problem problem{api::ProblemKind::unknown_mesh, "", {}};
  std::set<std::string> unknown;
  for (std::size_t i = 0; i < request.pairs.size(); ++i) {
    const api::BatchPair& pair = request.pairs[i];
    for (const auto& [part, mesh] : {std::pair("a", &pair.a), std::pair("b", &pair.b)}) {
      if (mesh->id.empty() || ids.contains(mesh->id)) continue;
      unknown.insert(mesh->id);
      if (problem.errors.size() == kMostErrors) continue;
      problem.errors.push_back({part, "/comparisons/" + std::to_string(i) + "/" + part,
                                "the mesh " + mesh->id + " is not stored; send it by PUT /v1/meshes/" + mesh->id});
    }
  }
  if (unknown.empty()) return std::nullopt;
  problem.detail = std::to_string(unknown.size()) + " of the batch's meshes are not stored, the first at " +
                   problem.errors.front().where + "; send them by PUT /v1/meshes/{id}";
  return problem;
}

store::NewBatch compose(const BatchHead& head, const api::BatchRequest& request,
                        const std::map<std::string, BatchFile>& files, const std::vector<store::MeshRow>& known) {
  const NamedMeshes meshes(files, known);
  store::NewBatch batch;
  batch.key = head.key;
  batch.name = request.name;
  batch.idempotency_key = head.idempotency_key;
  batch.created = head.created;
  batch.meshes = stored_ids(request);
  batch.items.reserve(request.pairs.size());
  for (const api::BatchPair& pair : request.pairs) {
    batch.items.push_back(item_of(head, pair, request.options[pair.options], meshes(pair.a), meshes(pair.b)));
  }
  if (!batch.idempotency_key.empty()) batch.fingerprint = fingerprint_of(request, batch);
  return batch;
}

}  // namespace meshgauge::server
