// Deviation maps that were made, kept as files for whoever asks again.
//
//   <folder>/<random>.part   being written
//   <folder>/<random>        whole, never changed
//
// What they are is known in memory alone: at the start the folder is emptied. It is a cache: what cannot be kept, on a
// full disk for instance, is not, and what is kept goes for what matters more.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <ostream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/result.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// A map of an owner's comparison: it is found under its whole key alone.
struct MapKey {
  store::JobKey job;
  std::string name;  // which map of it: "a.glb 20000"

  auto tied() const { return std::tie(job.owner, job.id, name); }
  bool operator<(const MapKey& other) const { return tied() < other.tied(); }
};

// Thread safe.
class MapCache {
 public:
  using File = std::shared_ptr<const store::Blob>;  // stays readable, whatever happens to the name
  using Write = std::function<Result<Done>(std::ostream&)>;

  static constexpr std::size_t kMostFiles = 10'000;

  struct Settings {
    std::string folder;           // used by this object alone
    std::uint64_t max_bytes = 0;  // of all files that are kept; 0: none is, and the folder is not made
    std::string temp_dir;         // for maps that are not kept, as files without a name
    // Bytes that the disk lacks for uploads and results; null: it never does.
    std::function<std::uint64_t()> lacking = nullptr;
  };

  struct Counters {
    std::uint64_t bytes = 0;  // now
    std::uint64_t files = 0;  // now
    std::uint64_t evictions = 0;
  };

  // A map that is on its way, the cache's own to look into. If its job or one of its meshes is forgotten meanwhile, it
  // is not kept.
  struct Coming {
    MapKey key;
    std::vector<std::string> meshes;
    bool forgotten = false;  // guarded by the cache
  };

  explicit MapCache(Settings settings) : settings_(std::move(settings)) {}

  // Before anything else: makes the folder and empties it.
  Result<Done> open();

  File find(const MapKey& key);  // null: it is not kept

  // Before it is seen that they are there, so that nothing is deleted unnoticed between. `meshes`: of the two meshes.
  std::shared_ptr<Coming> expect(const MapKey& key, const std::vector<std::string>& meshes);

  // The file that `write` writes. It is kept if it can be, the longest unused go for it. An Error is that of `write`,
  // or storage_full or storage_unavailable when it can be written nowhere; `write` may be called twice.
  Result<File> keep(const Coming& coming, const Write& write);

  void forget(const store::JobKey& job);
  void forget_mesh(const std::string& owner, const std::string& id);
  // Forgets the maps of all jobs that are not there any more.
  void sweep(const std::function<bool(const store::JobKey&)>& is_there);

  // Removes the longest unused maps, until what the disk lacks is free.
  void give_way();

  Counters counters() const;

 private:
  struct Entry {
    MapKey key;
    std::vector<std::string> meshes;
    std::string path;
    std::uint64_t bytes = 0;
  };
  using Entries = std::list<Entry>;  // the longest unused first
  using Paths = std::vector<std::string>;

  Result<File> write_named(const std::string& path, const Write& write);
  Result<File> write_unnamed(const Write& write);
  bool move_in(const Coming& coming, const std::string& path, std::uint64_t bytes);
  void drop_oldest(Paths& removed);
  void take_out(Entries::iterator at, Paths& removed);
  template <class Condition>
  void take_out_if(const Condition& condition);

  const Settings settings_;
  std::mutex giving_way_;     // before mutex_
  mutable std::mutex mutex_;  // guards what follows
  std::vector<std::weak_ptr<Coming>> coming_;
  Entries entries_;
  std::map<MapKey, Entries::iterator> by_key_;
  std::uint64_t bytes_ = 0;
  std::uint64_t evictions_ = 0;
};

}  // namespace meshgauge::server
