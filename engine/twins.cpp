#include "engine/twins.h"

#include <algorithm>

#include "engine/index_table.h"

namespace meshgauge {
namespace {

constexpr std::size_t kAskEvery = std::size_t{1} << 16;  // triangles, about 3 ms

LargeArray<std::uint64_t> vertex_hashes(const OrderedMesh& mesh) {
  LargeArray<std::uint64_t> hashes;
  hashes.reserve(mesh.positions.size());
  for (const Vec3& p : mesh.positions) hashes.push_back(hash_of(p));
  return hashes;
}

// The same for any order of the corners.
std::uint64_t hash_of(const Triangle& t, const LargeArray<std::uint64_t>& vertices) {
  return mix(vertices[t[0]] + vertices[t[1]] + vertices[t[2]]);
}

bool same_corners(const OrderedMesh& a, const Triangle& s, const OrderedMesh& b, const Triangle& t) {
  const auto equal = [&](std::size_t i, std::size_t j) { return a.positions[s[i]] == b.positions[t[j]]; };
  for (std::size_t j = 0; j < 3; ++j) {
    if (!equal(0, j)) continue;
    const std::size_t k = (j + 1) % 3, l = (j + 2) % 3;
    if ((equal(1, k) && equal(2, l)) || (equal(1, l) && equal(2, k))) return true;
  }
  return false;
}

}  // namespace

LargeArray<std::uint32_t> twins_by_number(const OrderedMesh& from, const OrderedMesh& to) {
  LargeArray<std::uint32_t> twins;
  if (from.original.size() > 2 * to.original.size() || to.original.size() > 2 * from.original.size()) return twins;
  LargeArray<std::uint32_t> place(to.original.size());  // by number in the caller's mesh
  for (std::uint32_t t = 0; t < to.original.size(); ++t) place[to.original[t]] = t;
  twins.reserve(from.original.size());
  for (const std::uint32_t number : from.original) twins.push_back(number < place.size() ? place[number] : kNoTwin);
  return twins;
}

LargeArray<std::uint32_t> twins_by_position(const OrderedMesh& from, const OrderedMesh& to,
                                            const Interrupted& interrupted) {
  LargeArray<std::uint32_t> twins;
  IndexTable table(to.triangles.size());
  const LargeArray<std::uint64_t> to_hashes = vertex_hashes(to), from_hashes = vertex_hashes(from);
  for (std::uint32_t t = 0; t < to.triangles.size(); ++t) {
    if (t % kAskEvery == kAskEvery - 1 && interrupted()) return twins;
    table.find_or_store(hash_of(to.triangles[t], to_hashes), t, [&](std::uint32_t other) {
      return same_corners(to, to.triangles[t], to, to.triangles[other]);
    });
  }
  twins.reserve(from.triangles.size());
  for (const Triangle& triangle : from.triangles) {
    if (twins.size() % kAskEvery == kAskEvery - 1 && interrupted()) return {};
    twins.push_back(table.find(hash_of(triangle, from_hashes), [&](std::uint32_t other) {
      return same_corners(from, triangle, to, to.triangles[other]);
    }));
  }
  return twins;
}

}  // namespace meshgauge
