// What a process that runs comparisons keeps and finds them in.
#pragma once

#include "server/jobs/mesh_cache.h"
#include "server/maps/map_cache.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server {

struct Stores {
  store::JobStore& jobs;
  store::MeshIndex& meshes;
  store::BlobStore& blobs;
  MeshCache& cache;
  MapCache* maps = nullptr;  // none: no deviation maps are made
};

// At once, so that nobody's deleted bytes fill the disk until the next sweep. For a process that has the stores to
// itself: the reservations that it goes by are those of this process.
Result<bool> remove_if_unreferenced(const Stores& stores, const store::BlobKey& key);

}  // namespace meshgauge::server
