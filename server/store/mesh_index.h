// What is known about the meshes that owners have stored, beside their bytes (BlobStore). In the same database as the
// jobs, with the same promises and errors (job_store.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

struct MeshRow {
  BlobKey key;
  std::uint64_t bytes = 0;
  std::string media_type;  // as its owner said; empty: nothing was said
  std::string file_name;   // likewise
  TimePoint created{};
  TimePoint last_used{};
  TimePoint expires{};
  bool operator==(const MeshRow&) const = default;
};

enum class MeshPut {
  created,
  existed,     // last_used and expires are renewed, the rest stays as it was
  over_quota,  // nothing was stored
};

struct PutMesh {
  MeshPut what = MeshPut::created;
  MeshRow row;  // as it is stored; over_quota: as it was given
};

class MeshIndex {
 public:
  virtual ~MeshIndex() = default;

  // The blob must be stored before. `max_stored_bytes`: what stored_bytes() of the owner may become by a new mesh.
  virtual Result<PutMesh> put_mesh(const MeshRow& row, std::uint64_t max_stored_bytes) = 0;
  virtual Result<std::optional<MeshRow>> get_mesh(const BlobKey& key) = 0;
  // Of those of the ids that there are, each once, in no order. This one asks for each by itself.
  virtual Result<std::vector<MeshRow>> known_meshes(const std::string& owner, std::span<const std::string> ids);
  // Of a mesh that is used. Returns at once, is durable within a second or so, and never takes a time back.
  virtual void touch_mesh(const BlobKey& key, TimePoint last_used, TimePoint expires) = 0;
  virtual Result<bool> delete_mesh(const BlobKey& key) = 0;  // false: there is none. The blob stays
  virtual Result<std::uint64_t> stored_bytes(const std::string& owner) = 0;
  virtual Result<std::uint64_t> all_stored_bytes() = 0;           // of all owners
  virtual Result<std::uint64_t> sweep_meshes(TimePoint now) = 0;  // forgets those whose time is over; how many
};

}  // namespace meshgauge::server::store
