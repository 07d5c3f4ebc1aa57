// The rows of meshes that owners have stored; their bytes are in the BlobStore. In the same database as the jobs, with
// the same guarantees and errors (job_store.h).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

struct MeshRow {
  BlobKey key;
  std::uint64_t bytes = 0;
  std::string media_type;  // as given by the owner; empty: none
  std::string file_name;   // as given by the owner; empty: none
  TimePoint created{};
  TimePoint last_used{};
  TimePoint expires{};
  bool operator==(const MeshRow&) const = default;
};

// The most that the meshes of an owner may be.
struct MeshQuota {
  std::uint64_t bytes;
  std::uint64_t meshes = std::numeric_limits<std::uint64_t>::max();
};

struct StoredMeshes {
  std::uint64_t bytes = 0;
  std::uint64_t meshes = 0;
};

enum class MeshPut {
  created,
  existed,     // last_used and expires were renewed, the rest is unchanged
  over_quota,  // of bytes: nothing was stored
  too_many,    // meshes: nothing was stored
};

// What a new mesh would be: created, over_quota or too_many.
MeshPut fits(const StoredMeshes& stored, std::uint64_t new_bytes, const MeshQuota& quota);

struct PutMesh {
  MeshPut what = MeshPut::created;
  MeshRow row;  // as stored; over_quota, too_many: as given
};

class MeshIndex {
 public:
  virtual ~MeshIndex() = default;

  // Stores a row, if stored() of the owner keeps to the quota with it. Precondition: the blob is stored.
  virtual Result<PutMesh> put_mesh(const MeshRow& row, const MeshQuota& quota) = 0;
  virtual Result<std::optional<MeshRow>> get_mesh(const BlobKey& key) = 0;
  // Returns the rows that exist, each once, in no order.
  virtual Result<std::vector<MeshRow>> known_meshes(const std::string& owner, std::span<const std::string> ids);
  // Notes that a mesh was used. Returns at once; becomes durable within about a second. Moves no time back.
  virtual void touch_mesh(const BlobKey& key, TimePoint last_used, TimePoint expires) = 0;
  virtual Result<bool> delete_mesh(const BlobKey& key) = 0;  // the row alone; false: no such mesh
  virtual Result<StoredMeshes> stored(const std::string& owner) = 0;
  virtual Result<std::uint64_t> all_stored_bytes() = 0;                  // of all owners
  virtual Result<std::vector<BlobKey>> sweep_meshes(TimePoint now) = 0;  // removes expired rows; returns their keys
};

}  // namespace meshgauge::server::store
