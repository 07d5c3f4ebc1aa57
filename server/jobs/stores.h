// What a service keeps, as its handlers are given it.
#pragma once

#include "server/jobs/mesh_cache.h"
#include "server/maps/map_cache.h"
#include "server/store/batch_store.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/mesh_index.h"
#include "server/store/signals.h"

namespace meshgauge::server {

struct Stores {
  store::JobStore& jobs;
  store::MeshIndex& meshes;
  store::BlobStore& blobs;
  MeshCache& cache;
  MapCache* maps = nullptr;              // none: no deviation maps are made
  store::Signals* signals = nullptr;     // none: nobody else works on these stores
  store::BatchStore* batches = nullptr;  // none: there are no batches

  bool shared() const { return signals != nullptr; }
};

}  // namespace meshgauge::server
