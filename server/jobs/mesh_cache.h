// Meshes that were measured, kept with their trees for the next comparison: a baseline is read and prepared once.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/formats/format.h"
#include "api/prepared_mesh.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::server {

// Thread safe. May be destroyed while meshes are in use: they live as long as somebody holds them.
//
// The budget covers arrays, trees and tables of all meshes here; those grow while they are measured, and are counted
// anew whenever a user is done. What exceeds the budget goes at once, the longest unused first; what is in use stays
// until its last user is done. So more than the budget is held only while running jobs use more than it themselves.
class MeshCache {
 public:
  // A mesh belongs to one owner, and so does what is kept of it: others who sent the same bytes have their own. The
  // hints are part of the name, as they may decide what the bytes are read as.
  struct Key {
    std::string owner;
    std::string id;  // SHA-256 of the file, 64 lower-case hex digits
    std::optional<api::Format> filename_says;
    std::optional<api::Format> media_type_says;

    auto operator<=>(const Key&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
  };

  // Gets the mesh from its file. An Error is about the file, or out_of_time when `control` said to stop.
  using Load = std::function<Result<api::SharedMesh>(Control& control)>;

  static Key key(std::string owner, std::string id, std::string_view filename, std::string_view media_type);

  struct Counters {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;     // each loads, and may fail
    std::uint64_t evictions = 0;  // for want of room
    std::uint64_t bytes = 0;      // now
    std::uint64_t meshes = 0;     // now
    std::uint64_t in_use = 0;     // of those, being loaded or measured
  };

  explicit MeshCache(std::uint64_t max_bytes);

  // The mesh kept under this key, or what `load` gives, which should prepare it for being used often. One load at a
  // time for a key: others wait, asking their `control` every 10 ms, and what fails is not kept; then one of those who
  // waited loads. An Error is load's, or has the code out_of_time when `control` said to stop, or internal when the
  // file is not the one that `key` names. Throws what load throws.
  Result<api::SharedMesh> get(const Key& key, const Load& load, Control& control);

  // Nothing of that mesh will be found any more; who uses it keeps it until done.
  void forget(const std::string& owner, const std::string& id);

  Counters counters() const;

 private:
  class Shelf;
  std::shared_ptr<Shelf> shelf_;  // shared with the users of meshes, who give them back
};

}  // namespace meshgauge::server
