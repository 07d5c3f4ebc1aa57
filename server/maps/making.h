// The making of one deviation map, by one worker thread for all clients that wait for it.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/result/response.h"
#include "engine/control.h"
#include "server/jobs/jobs.h"
#include "server/maps/map_query.h"
#include "server/measure/map_cache.h"

namespace meshgauge::server {

// What a worker thread needs to make a map.
struct MapOrder {
  MapKey key;
  std::string client;  // that shares are counted for
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
  std::vector<api::Stage> stages;  // empty: the map was cached
};

class Making {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Making(MapOrder what);

  const MapOrder order;
  const Clock::time_point submitted = Clock::now();
  Control control;
  std::atomic<bool> begun{false};  // a worker makes it, or has made it
  std::size_t watchers = 0;        // waiting clients; guarded by the handler's mutex

  void end(Result<MadeFile> result);  // call it once
  // Returns the result, which does not change any more; null: not yet.
  const Result<MadeFile>* result() const;
  void on_end(std::function<void()> wake);  // calls `wake`, which must not block, when the result is there

 private:
  mutable std::mutex mutex_;
  std::vector<std::function<void()>> wakes_;  // guarded by the mutex
  std::optional<Result<MadeFile>> result_;    // guarded by the mutex until it is set
};

// What maps are made with; borrowed, except the settings.
struct MapTools {
  const Settings settings;
  MeshLoader& loader;
  MapCache& cache;
  ThreadBudget& threads;
  MemoryBudget& memory;
};

// Reads the meshes, measures the deviations and writes the map, on the calling thread. Errors: those of a comparison;
// too_large: the map does not fit the requested format, or max_heap_bytes; storage_full. Does not throw.
Result<MadeFile> make_map(Making& making, const MapTools& tools);

}  // namespace meshgauge::server
