#include "server/measure/caching_mesh_loader.h"

#include "api/compare/prepared_mesh.h"

namespace meshgauge::server {

Result<api::SharedMesh> CachingMeshLoader::load(const MeshSource& source, MemoryReservation& memory, Control& job) {
  const auto read = [&](Prepared::Use use, Control& control) {
    return api::prepare(pool_.load(source.input, limits_, control, &memory), source.input, use, control);
  };
  if (!source.kept) return read(Prepared::Use::once, job);
  const std::uint64_t before = memory.taken_meshes();
  auto mesh = cache_.get(
      *source.kept, [&](Control& control) { return read(Prepared::Use::often, control); }, job);
  if (!mesh || memory.taken_meshes() > before) return mesh;
  // One that was cached: it may leave the cache while it is in use.
  const MeshView arrays = (*mesh)->mesh.mesh();
  if (const auto ok = memory.take_mesh(arrays.positions.size(), arrays.triangles.size()); !ok) return ok.error();
  return mesh;
}

}  // namespace meshgauge::server
