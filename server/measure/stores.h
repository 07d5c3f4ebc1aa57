// The stores and caches of a service, for its handlers, and their errors, which name no path: clients are told them.
#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <utility>

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
  std::string place = {};                // where they are, for the log: clients are not told
};

// For the log: what is wrong, and where. An empty `place` is left out.
std::string located(const std::string& defect, const std::string& place);

// Counts and logs errors of the store. Repetitions of one message are logged once in a while. Thread safe.
class StoreErrors {
 public:
  // Borrows the metrics. `place`: as in Stores.
  explicit StoreErrors(Metrics& metrics, std::string place = "") : metrics_(metrics), place_(std::move(place)) {}

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
  const std::string place_;
  std::mutex mutex_;
  std::string last_;
  std::chrono::steady_clock::time_point logged_;
};

}  // namespace meshgauge::server
