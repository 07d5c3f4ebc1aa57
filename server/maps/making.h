// One deviation map on its way: made once by a worker, for all clients that wait for it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "api/response.h"
#include "engine/control.h"
#include "server/jobs/jobs.h"
#include "server/maps/map_cache.h"
#include "server/maps/map_query.h"

namespace meshgauge::server {

// All that a worker needs to know.
struct MapOrder {
  MapKey key;
  std::shared_ptr<const MapCache::Coming> coming;
  MapQuery query;
  MeshSource a;
  MeshSource b;
  api::ResultFacts facts;
  std::uint64_t bytes = 0;  // of both files
  std::chrono::milliseconds timeout{30'000};
};

struct MadeFile {
  MapCache::File file;
  std::vector<api::Stage> stages;  // none: it was there already
};

class Making {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Making(MapOrder what);

  const MapOrder order;
  const Clock::time_point submitted = Clock::now();
  Control control;
  std::size_t watchers = 0;  // clients that wait; guarded by whoever counts them

  void end(Result<MadeFile> result);  // once
  // The result, within `time`; then it stays as it is.
  const Result<MadeFile>* wait(std::chrono::milliseconds time) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable ended_;
  std::optional<Result<MadeFile>> result_;  // guarded by the mutex until it is there
};

// What maps are made with. Borrowed, but for the settings.
struct MapTools {
  const Settings settings;
  const Fetch& fetch;
  MapCache& cache;
  ThreadBudget& threads;
};

// Reads, measures, writes: on a worker. An Error is as that of a comparison; too_large: the map cannot be written as
// what was asked for, or not within max_heap_bytes; storage_full. Does not throw.
Result<MadeFile> make_map(Making& making, const MapTools& tools);

}  // namespace meshgauge::server
