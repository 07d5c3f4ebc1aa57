// A cache of deviation maps, as files.
//
//   <folder>/<random>.part   being written
//   <folder>/<random>        complete, never changed
//
// The index is in memory alone, so a start empties the folder. A map that cannot be kept, for instance on a full disk,
// is not kept; maps are removed when uploads and results need the room.
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

// The key of a map of an owner's comparison.
struct MapKey {
  store::JobKey job;
  std::string name;  // MapQuery::name(): "a.glb 20000"

  auto tied() const { return std::tie(job.owner, job.id, name); }
  bool operator<(const MapKey& other) const { return tied() < other.tied(); }
};

// Thread safe.
class MapCache {
 public:
  using File = std::shared_ptr<const store::Blob>;  // stays readable when the file is removed
  using Write = std::function<Result<Done>(std::ostream&)>;

  static constexpr std::size_t kMostFiles = 10'000;

  struct Settings {
    std::string folder;           // of this object alone
    std::uint64_t max_bytes = 0;  // of all kept files; 0: none is kept, and the folder is not created
    std::string temp_dir;         // for maps that are not kept, as files without a name
    // Returns the bytes that the disk lacks for uploads and results. null: always 0.
    std::function<std::uint64_t()> lacking = nullptr;
  };

  struct Counters {
    std::uint64_t bytes = 0;  // now
    std::uint64_t files = 0;  // now
    std::uint64_t evictions = 0;
  };

  // A map that is being made; opaque to callers. It is not kept if its job or one of its meshes is forgotten meanwhile.
  struct Coming {
    MapKey key;
    std::vector<std::string> meshes;
    bool forgotten = false;  // guarded by the cache
  };

  explicit MapCache(Settings settings) : settings_(std::move(settings)) {}

  // Creates and empties the folder. Call it before anything else.
  Result<Done> open();

  File find(const MapKey& key);  // null: not cached

  // Registers a map. Call it before checking that the job and its meshes exist, so that no deletion goes unnoticed.
  // `meshes`: ids of the two meshes.
  std::shared_ptr<Coming> expect(const MapKey& key, const std::vector<std::string>& meshes);

  // Returns the file that `write` writes, and caches it if there is room, removing the longest unused. Errors: those of
  // `write`; storage_full or storage_unavailable when no folder takes the file. May call `write` twice.
  Result<File> keep(const Coming& coming, const Write& write);

  void forget(const store::JobKey& job);
  void forget_mesh(const std::string& owner, const std::string& id);
  // Removes the maps of jobs that no longer exist.
  void sweep(const std::function<bool(const store::JobKey&)>& is_there);

  // Removes the longest unused maps until `lacking` returns 0.
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
  std::mutex giving_way_;     // locked before mutex_
  mutable std::mutex mutex_;  // guards the members below
  std::vector<std::weak_ptr<Coming>> coming_;
  Entries entries_;
  std::map<MapKey, Entries::iterator> by_key_;
  std::uint64_t bytes_ = 0;
  std::uint64_t evictions_ = 0;
};

// Free room on a disk that the cache must leave for uploads and results.

// Size and free bytes of a disk.
struct DiskRoom {
  std::uint64_t bytes = 0;
  std::uint64_t free = 0;
};

// Returns the bytes that are missing until `wanted` bytes, or a sixty-fourth of the disk if that is less, are free.
std::uint64_t lacking_bytes(DiskRoom disk, std::uint64_t wanted);

// The same for the folder's disk; 0 if its size is unknown.
std::uint64_t lacking_bytes_on(const std::string& folder, std::uint64_t wanted);

}  // namespace meshgauge::server
