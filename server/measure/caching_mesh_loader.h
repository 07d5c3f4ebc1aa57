// Loads the meshes of comparisons and deviation maps.
#pragma once

#include "server/measure/measuring.h"
#include "server/measure/mesh_cache.h"
#include "server/sandbox/pool.h"

namespace meshgauge::server {

// Loads a mesh from the cache if it is a stored mesh, else by the pool. Borrows both.
class CachingMeshLoader final : public MeshLoader {
 public:
  CachingMeshLoader(sandbox::Pool& pool, MeshCache& cache, const api::ReadLimits& limits)
      : pool_(pool), cache_(cache), limits_(limits) {}

  Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation& memory, Control& job) override;

 private:
  sandbox::Pool& pool_;
  MeshCache& cache_;
  const api::ReadLimits limits_;
};

}  // namespace meshgauge::server
