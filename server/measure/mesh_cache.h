// A cache of loaded meshes with their trees, so that a baseline is read and prepared once.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/compare/prepared_mesh.h"
#include "api/formats/format.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::server {

// Thread safe. May be destroyed while meshes are in use: they live as long as they are referenced.
//
// The budget covers arrays, trees and tables of all cached meshes; these grow while they are measured, and are counted
// again whenever a use ends. Beyond the budget, meshes are evicted at once, the longest unused first; a mesh in use
// stays until its last use ends. So more than the budget is held only while running jobs use more than it.
class MeshCache {
 public:
  // Each owner has entries of its own, also for equal bytes. The hints are part of the key, because they may decide the
  // format that the bytes are read as.
  struct Key {
    std::string owner;
    std::string id;  // SHA-256 of the file, 64 lower-case hex digits
    std::optional<api::Format> filename_says;
    std::optional<api::Format> media_type_says;

    auto operator<=>(const Key&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
  };

  // Loads the mesh from its file. Errors: those of the file; out_of_time when `control` stops it.
  using Load = std::function<Result<api::SharedMesh>(Control& control)>;

  static Key key(std::string owner, std::string id, std::string_view filename, std::string_view media_type);

  struct Counters {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;     // loads, also failed ones
    std::uint64_t evictions = 0;  // beyond the budget
    std::uint64_t bytes = 0;      // now
    std::uint64_t meshes = 0;     // now
    std::uint64_t in_use = 0;     // of those: being loaded or measured
  };

  explicit MeshCache(std::uint64_t max_bytes);

  // Returns the cached mesh, or loads it; `load` should prepare it for repeated use. One load at a time for a key:
  // other calls block, and check their `control` every 10 ms. A failed load is not cached; then one of the waiting
  // calls loads. Errors: those of `load`; out_of_time when `control` stops the call; internal when the file is not the
  // one that `key` names. Throws what `load` throws.
  Result<api::SharedMesh> get(const Key& key, const Load& load, Control& control);

  // Removes the mesh from the cache; running uses keep it until they end.
  void forget(const std::string& owner, const std::string& id);

  Counters counters() const;

 private:
  class Shelf;
  std::shared_ptr<Shelf> shelf_;  // shared with the uses, which return their meshes to it
};

}  // namespace meshgauge::server
