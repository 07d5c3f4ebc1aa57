#include "engine/twins.h"

#include <algorithm>
#include <vector>

#include "engine/index_table.h"

namespace meshgauge {
namespace {

constexpr std::size_t kAskEvery = std::size_t{1} << 13;  // triangles or positions, 5 ms at most
constexpr std::size_t kSample = 64;                      // triangles

bool same_corners(const MeshView& a, std::size_t s, const MeshView& b, std::size_t t) {
  const auto equal = [&](int i, int j) { return a.corner(s, i) == b.corner(t, j); };
  for (int j = 0; j < 3; ++j) {
    if (!equal(0, j)) continue;
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    if ((equal(1, k) && equal(2, l)) || (equal(1, l) && equal(2, k))) return true;
  }
  return false;
}

// The same for any order of the corners.
std::uint64_t triangle_hash(MeshView mesh, std::size_t t) {
  return mix(hash_of(mesh.corner(t, 0)) + hash_of(mesh.corner(t, 1)) + hash_of(mesh.corner(t, 2)));
}

// Calls visit(i) for each i below `count`. False: interrupted.
template <class Visit>
bool each(std::size_t count, const Interrupted& interrupted, Visit&& visit) {
  for (std::size_t i = 0; i < count; ++i) {
    if (i % kAskEvery == kAskEvery - 1 && interrupted()) return false;
    visit(static_cast<std::uint32_t>(i));
  }
  return true;
}

bool holds(const Box& box, const Vec3& p) {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

// Whether all corners of at least every other triangle of a sample are positions of `to`, which need not be used there.
// False, too, when interrupted.
bool seems_shared(MeshView from, MeshView to, const Box& to_box, const Interrupted& interrupted) {
  const std::size_t step = from.triangles.size() / kSample + 1;
  std::vector<Vec3> corners;
  std::size_t inside = 0;
  for (std::size_t t = 0; t < from.triangles.size(); t += step) {
    for (int i = 0; i < 3; ++i) corners.push_back(from.corner(t, i));
    if (holds(to_box, corners.back())) ++inside;
  }
  const std::size_t enough = (corners.size() / 3 + 1) / 2;
  if (inside < enough) return false;
  IndexTable table(corners.size());
  std::vector<std::uint32_t> first_equal(corners.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    const auto is_equal = [&](std::uint32_t j) { return corners[j] == corners[i]; };
    const std::uint32_t known = table.find_or_store(hash_of(corners[i]), i, is_equal);
    first_equal[i] = known == IndexTable::kNone ? i : known;
  }
  std::vector<bool> found(corners.size());
  const bool done = each(to.positions.size(), interrupted, [&](std::uint32_t v) {
    const Vec3& p = to.positions[v];
    const std::uint32_t i = table.find(hash_of(p), [&](std::uint32_t j) { return corners[j] == p; });
    if (i != IndexTable::kNone) found[i] = true;
  });
  if (!done) return false;
  std::size_t shared = 0;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    if (found[first_equal[i]] && found[first_equal[i + 1]] && found[first_equal[i + 2]]) ++shared;
  }
  return shared >= enough;
}

bool same_number(const MeshView& a, const MeshView& b, std::size_t t) {
  return t < b.triangles.size() && same_corners(a, t, b, t);
}

// Whether every other triangle of a sample has its twin under its own number.
bool numbers_agree(MeshView from, MeshView to) {
  const std::size_t step = from.triangles.size() / kSample + 1;
  std::size_t sampled = 0, agree = 0;
  for (std::size_t t = 0; t < from.triangles.size(); t += step) {
    ++sampled;
    if (same_number(from, to, t)) ++agree;
  }
  return 2 * agree >= sampled;
}

LargeArray<std::uint32_t> twins_in_table(MeshView from, MeshView to, const Interrupted& interrupted) {
  IndexTable table(to.triangles.size());
  LargeArray<std::uint64_t> hashes(to.triangles.size());
  const auto is_equal = [&](std::uint64_t hash, MeshView mesh, std::size_t t) {
    return
        [&, hash, mesh, t](std::uint32_t other) { return hashes[other] == hash && same_corners(mesh, t, to, other); };
  };
  const bool filed = each(to.triangles.size(), interrupted, [&](std::uint32_t t) {
    hashes[t] = triangle_hash(to, t);
    table.find_or_store(hashes[t], t, is_equal(hashes[t], to, t));
  });
  if (!filed) return {};
  LargeArray<std::uint32_t> twins;
  twins.reserve(from.triangles.size());
  const bool found = each(from.triangles.size(), interrupted, [&](std::uint32_t t) {
    const std::uint64_t hash = triangle_hash(from, t);
    twins.push_back(table.find(hash, is_equal(hash, from, t)));
  });
  if (!found) twins.clear();
  return twins;
}

}  // namespace

LargeArray<std::uint32_t> twins_by_number(const OrderedMesh& from, const OrderedMesh& to) {
  LargeArray<std::uint32_t> twins;
  if (from.given > 2 * to.given || to.given > 2 * from.given) return twins;
  LargeArray<std::uint32_t> place(to.given);  // by number in the caller's mesh
  for (std::uint32_t t = 0; t < to.original.size(); ++t) place[to.original[t]] = t;
  twins.reserve(from.original.size());
  for (const std::uint32_t number : from.original) twins.push_back(number < place.size() ? place[number] : kNoTwin);
  return twins;
}

LargeArray<std::uint32_t> shared_triangles(MeshView from, MeshView to, const Box& to_box,
                                           const Interrupted& interrupted) {
  LargeArray<std::uint32_t> twins;
  if (!seems_shared(from, to, to_box, interrupted)) return twins;
  if (!numbers_agree(from, to)) return twins_in_table(from, to, interrupted);
  twins.reserve(from.triangles.size());
  const bool done = each(from.triangles.size(), interrupted,
                         [&](std::uint32_t t) { twins.push_back(same_number(from, to, t) ? t : kNoTwin); });
  if (!done) twins.clear();
  return twins;
}

}  // namespace meshgauge
