#include "engine/fast/twins.h"

#include <algorithm>
#include <span>
#include <vector>

#include "engine/mesh/index_table.h"
#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

constexpr std::size_t kSample = 64;  // triangles
constexpr std::size_t kRoomy = 16;   // times the room that the sample needs: a search mostly meets an empty place
constexpr std::size_t kFewOf = 64;   // a smaller part of a mesh is not worth an array over the whole of the other one

bool holds(const Box& box, const Vec3& p) {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

// Returns for each point whether it is a position of `to`. Empty: interrupted.
std::vector<bool> are_positions(std::span<const Vec3> points, MeshView to, const Interrupted& interrupted) {
  IndexTable table(kRoomy * points.size());
  std::vector<std::uint32_t> first_equal(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto is_equal = [&](std::uint32_t j) { return points[j] == points[i]; };
    const std::uint32_t known = table.find_or_store(hash_of(points[i]), i, is_equal);
    first_equal[i] = known == IndexTable::kNone ? i : known;
  }
  std::vector<bool> found(points.size());
  const bool done = each_unless(interrupted, to.positions.size(), [&](std::uint32_t v) {
    const Vec3& p = to.positions[v];
    const std::uint32_t i = table.find(hash_of(p), [&](std::uint32_t j) { return points[j] == p; });
    if (i != IndexTable::kNone) found[i] = true;
  });
  if (!done) return {};
  for (std::size_t i = 0; i < points.size(); ++i) found[i] = found[first_equal[i]];
  return found;
}

// The same. It uses the index if `to` is used often: making the index takes longer than one pass over all positions.
std::vector<bool> are_positions(std::span<const Vec3> points, const Prepared& to, const Interrupted& interrupted) {
  if (to.use() == Prepared::Use::once) return are_positions(points, to.mesh(), interrupted);
  const PositionIndex* index = to.positions(interrupted);
  if (!index) return {};
  std::vector<bool> found(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) found[i] = index->holds(points[i]);
  return found;
}

// Whether for at least half of a sample of triangles all corners are positions of `to`, used there or not. False also
// when interrupted.
bool seems_shared(MeshView from, const Prepared& to, const Interrupted& interrupted) {
  const std::size_t step = from.triangles.size() / kSample + 1;
  std::vector<Vec3> corners;
  std::size_t inside = 0;
  for (std::size_t t = 0; t < from.triangles.size(); t += step) {
    for (int i = 0; i < 3; ++i) corners.push_back(from.corner(t, i));
    if (holds(to.box(), corners.back())) ++inside;
  }
  const std::size_t enough = (corners.size() / 3 + 1) / 2;
  if (inside < enough) return false;
  const std::vector<bool> found = are_positions(corners, to, interrupted);
  std::size_t shared = 0;
  for (std::size_t i = 0; i < found.size(); i += 3) {
    if (found[i] && found[i + 1] && found[i + 2]) ++shared;
  }
  return shared >= enough;
}

bool same_number(const MeshView& a, const MeshView& b, std::size_t t) {
  return t < b.triangles.size() && same_corners(a, t, b, t);
}

// Whether at least half of a sample of triangles have their twin under their own number.
bool numbers_agree(MeshView from, MeshView to) {
  const std::size_t step = from.triangles.size() / kSample + 1;
  std::size_t sampled = 0, agree = 0;
  for (std::size_t t = 0; t < from.triangles.size(); t += step) {
    ++sampled;
    if (same_number(from, to, t)) ++agree;
  }
  return 2 * agree >= sampled;
}

LargeArray<std::uint32_t> twins_by_corners(MeshView from, const TriangleIndex& to, const Interrupted& interrupted) {
  LargeArray<std::uint32_t> twins;
  twins.reserve(from.triangles.size());
  const bool done =
      each_unless(interrupted, from.triangles.size(), [&](std::uint32_t t) { twins.push_back(to.find(from, t)); });
  if (!done) twins.clear();
  return twins;
}

LargeArray<std::uint32_t> twins_by_corners(MeshView from, const Prepared& to, const Interrupted& interrupted) {
  if (to.use() == Prepared::Use::often) {
    const TriangleIndex* index = to.triangles(interrupted);
    return index ? twins_by_corners(from, *index, interrupted) : LargeArray<std::uint32_t>();
  }
  const TriangleIndex index(to.mesh(), interrupted);
  return index.complete() ? twins_by_corners(from, index, interrupted) : LargeArray<std::uint32_t>();
}

}  // namespace

LargeArray<std::uint32_t> twins_by_number(const OrderedMesh& from, const OrderedMesh& to) {
  LargeArray<std::uint32_t> twins;
  if (from.given > 2 * to.given || to.given > 2 * from.given) return twins;
  if (kFewOf * from.original.size() < to.given) return twins;
  LargeArray<std::uint32_t> place(to.given, kNoTwin);  // by number in the given mesh
  for (std::uint32_t t = 0; t < to.original.size(); ++t) place[to.original[t]] = t;
  twins.reserve(from.original.size());
  for (const std::uint32_t number : from.original) twins.push_back(number < place.size() ? place[number] : kNoTwin);
  return twins;
}

LargeArray<std::uint32_t> shared_triangles(MeshView from, const Prepared& to, const Interrupted& interrupted) {
  if (!seems_shared(from, to, interrupted)) return {};
  if (!numbers_agree(from, to.mesh())) return twins_by_corners(from, to, interrupted);
  LargeArray<std::uint32_t> twins;
  twins.reserve(from.triangles.size());
  const bool done = each_unless(interrupted, from.triangles.size(), [&](std::uint32_t t) {
    twins.push_back(same_number(from, to.mesh(), t) ? t : kNoTwin);
  });
  if (!done) twins.clear();
  return twins;
}

}  // namespace meshgauge
