#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

// Does not depend on the order of the corners.
std::uint64_t triangle_hash(MeshView mesh, std::size_t t) {
  return mix(hash_of(mesh.corner(t, 0)) + hash_of(mesh.corner(t, 1)) + hash_of(mesh.corner(t, 2)));
}

}  // namespace

bool same_corners(MeshView a, std::size_t s, MeshView b, std::size_t t) {
  const auto equal = [&](int i, int j) { return a.corner(s, i) == b.corner(t, j); };
  for (int j = 0; j < 3; ++j) {
    if (!equal(0, j)) continue;
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    if ((equal(1, k) && equal(2, l)) || (equal(1, l) && equal(2, k))) return true;
  }
  return false;
}

PositionIndex::PositionIndex(MeshView mesh, const Interrupted& interrupted)
    : mesh_(mesh), table_(mesh.positions.size()) {
  complete_ = each_unless(interrupted, mesh.positions.size(), [&](std::uint32_t v) {
    const Vec3& p = mesh.positions[v];
    table_.find_or_store(hash_of(p), v, [&](std::uint32_t u) { return mesh_.positions[u] == p; });
  });
}

bool PositionIndex::holds(const Vec3& p) const {
  return table_.find(hash_of(p), [&](std::uint32_t v) { return mesh_.positions[v] == p; }) != IndexTable::kNone;
}

auto TriangleIndex::is_equal(std::uint64_t hash, MeshView from, std::size_t t) const {
  return [this, hash, from, t](std::uint32_t other) {
    return hashes_[other] == hash && same_corners(from, t, mesh_, other);
  };
}

TriangleIndex::TriangleIndex(MeshView mesh, const Interrupted& interrupted)
    : mesh_(mesh), table_(mesh.triangles.size()), hashes_(mesh.triangles.size()) {
  complete_ = each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
    hashes_[t] = triangle_hash(mesh_, t);
    table_.find_or_store(hashes_[t], t, is_equal(hashes_[t], mesh_, t));
  });
}

std::uint32_t TriangleIndex::find(MeshView from, std::size_t t) const {
  const std::uint64_t hash = triangle_hash(from, t);
  return table_.find(hash, is_equal(hash, from, t));
}

}  // namespace meshgauge
