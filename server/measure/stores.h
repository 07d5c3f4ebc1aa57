// The stores and caches of a service, for its handlers.
#pragma once

#include "server/measure/map_cache.h"
#include "server/measure/mesh_cache.h"
#include "server/store/batch_store.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/listings.h"
#include "server/store/mesh_index.h"
#include "server/store/signals.h"

namespace meshgauge::server {

struct Stores {
  store::JobStore& jobs;
  store::MeshIndex& meshes;
  store::BlobStore& blobs;
  store::Signals& signals;
  MeshCache& cache;
  bool shared = false;                   // other processes use these stores: workers run the jobs
  MapCache* maps = nullptr;              // null: no deviation maps are made
  store::BatchStore* batches = nullptr;  // null: there are no batches
  store::Listings* listings = nullptr;   // null: nothing is listed
};

}  // namespace meshgauge::server
