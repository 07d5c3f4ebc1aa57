#include "server/store/mesh_index.h"

#include <set>

namespace meshgauge::server::store {

Result<std::vector<MeshRow>> MeshIndex::known_meshes(const std::string& owner, std::span<const std::string> ids) {
  std::vector<MeshRow> known;
  for (const std::string& id : std::set<std::string>(ids.begin(), ids.end())) {
    Result<std::optional<MeshRow>> row = get_mesh({owner, id});
    if (!row) return row.error();
    if (*row) known.push_back(std::move(**row));
  }
  return known;
}

MeshPut fits(const StoredMeshes& stored, std::uint64_t new_bytes, const MeshQuota& quota) {
  if (new_bytes > quota.bytes || stored.bytes > quota.bytes - new_bytes) return MeshPut::over_quota;
  return stored.meshes < quota.meshes ? MeshPut::created : MeshPut::too_many;
}

}  // namespace meshgauge::server::store
