#include "server/measure/revived.h"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/hausdorff.h"

namespace meshgauge::server {

api::Request limited(api::Request request, const Settings& settings) {
  request.options.simd = settings.simd;
  std::size_t& memory_bytes = request.options.max_memory_bytes;
  memory_bytes = std::min<std::size_t>(memory_bytes, settings.max_heap_bytes);
  return request;
}

std::shared_ptr<LiveJob> live_job_of(const store::Job& row, const Settings& settings,
                                     std::chrono::milliseconds waited) {
  MeshSource a{{"a", {}, "", "", -1}, nullptr, row.mesh_a, {}};
  MeshSource b{{"b", {}, "", "", -1}, nullptr, row.mesh_b, {}};
  set_hints(row.hints, a, b);
  auto request = api::parse_options(row.options, request_limits(settings));
  auto job = std::make_shared<LiveJob>(row, request ? limited(*request, settings) : api::Request{}, std::move(a),
                                       std::move(b), true, LiveJob::Clock::now() - waited);
  if (!request) job->defect = request.error();
  if (row.progress && row.progress->by == version()) job->progressed(*row.progress);
  return job;
}

Result<Done> recognise_meshes(LiveJob& job, store::MeshIndex& meshes) {
  const auto known = meshes.known_meshes(job.key.owner, std::array{job.a.id, job.b.id});
  if (!known) return known.error();
  for (MeshSource* source : {&job.a, &job.b}) {
    const bool stored = std::any_of(known->begin(), known->end(),
                                    [source](const store::MeshRow& row) { return row.key.id == source->id; });
    if (!stored) continue;
    source->kept = MeshCache::key(job.key.owner, source->id, source->input.filename, source->input.media_type);
  }
  return Done{};
}

Result<Done> open_blobs(LiveJob& job, store::BlobStore& blobs) {
  for (MeshSource* source : {&job.a, &job.b}) {
    auto blob = blobs.open({job.key.owner, source->id});
    if (!blob) return blob.error();
    if (*blob) hold_bytes(*source, std::move(**blob));
  }
  return Done{};
}

}  // namespace meshgauge::server
