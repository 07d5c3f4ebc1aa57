// The stores and caches of a service, for its handlers, and their errors.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "engine/result.h"
#include "server/measure/map_cache.h"
#include "server/measure/mesh_cache.h"
#include "server/observe/metrics.h"
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

// Counts and logs errors of the store. Repetitions of one message are logged once in a while. Thread safe.
class StoreErrors {
 public:
  explicit StoreErrors(Metrics& metrics) : metrics_(metrics) {}  // borrows it

  // Notes the error of any Result, if it has one.
  void note(const auto& result) {
    if (!result) failed(result.error());
  }
  // The same, for a result that is used: returns it.
  template <class T>
  Result<T> noted(Result<T> result) {
    note(result);
    return result;
  }

 private:
  void failed(const Error& error);

  Metrics& metrics_;
  std::mutex mutex_;
  std::string last_;
  std::chrono::steady_clock::time_point logged_;
};

}  // namespace meshgauge::server
