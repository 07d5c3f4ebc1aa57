#include "server/jobs/revived.h"

#include <algorithm>
#include <utility>

namespace meshgauge::server {
namespace {

// A mesh that its owner stored as such is worth keeping in memory.
Result<Done> recognise(const std::string& owner, MeshSource& source, store::MeshIndex& meshes) {
  const auto stored = meshes.get_mesh({owner, source.id});
  if (!stored) return stored.error();
  if (!*stored) return Done{};
  source.kept = MeshCache::key(owner, source.id, source.input.filename, source.input.media_type);
  return Done{};
}

}  // namespace

api::Request limited(api::Request request, const Settings& settings) {
  request.options.simd = settings.simd;
  std::size_t& memory_bytes = request.options.max_memory_bytes;
  memory_bytes = std::min<std::size_t>(memory_bytes, settings.max_heap_bytes);
  return request;
}

Result<std::shared_ptr<LiveJob>> revived(const store::Job& row, const Settings& settings, store::MeshIndex& meshes) {
  MeshSource a{{"a", {}, "", "", -1}, nullptr, row.mesh_a, {}};
  MeshSource b{{"b", {}, "", "", -1}, nullptr, row.mesh_b, {}};
  set_hints(row.hints, a, b);
  for (MeshSource* source : {&a, &b}) {
    if (auto done = recognise(row.key.owner, *source, meshes); !done) return done.error();
  }
  auto request = api::parse_options(row.options, request_limits(settings));
  auto job = std::make_shared<LiveJob>(row, request ? limited(std::move(*request), settings) : api::Request{},
                                       std::move(a), std::move(b), true);
  if (!request) job->defect = request.error();
  return job;
}

}  // namespace meshgauge::server
