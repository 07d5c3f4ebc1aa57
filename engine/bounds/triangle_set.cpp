#include "engine/bounds/triangle_set.h"

#include "engine/rounding.h"
#include "engine/triangle_distance.h"

namespace meshgauge {
namespace {

constexpr double kSetMargin = 256 * rounding::kUnit;
constexpr std::size_t kPulseEvery = 1024;  // triangle-triangle distances between two looks at the clock, about 1 ms

double box_distance_sq(const Box& a, const Box& b) {
  return (a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(Vec3::Zero()).squaredNorm();
}

CornersAndFrame with_frame(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{a, b, c}, prepare(a, b, c).triangle};
}

}  // namespace

Corner TriangleSet::measure(const Vec3& p, const Piece& parent) {
  const Slots* slots = set_of(parent);
  if (!slots) return nearest_corner(search_.to(), p, search_.work());
  search_.work().triangle_tests += slots->size();
  Corner corner{p, std::numeric_limits<double>::infinity(), Nearest::kNone};
  for (const std::uint32_t slot : *slots) {
    const double d = distance(search_.to().prepared(slot), p);
    if (d < corner.distance) corner.distance = d, corner.slot = slot;
  }
  return corner;
}

double TriangleSet::upper(const Piece& piece) {
  if (piece.depth == 0) return least_farthest(piece, search_.to(), collect(piece).slots, search_.work());
  if (const Slots* slots = set_of(piece)) return least_farthest(piece, search_.to(), *slots, search_.work());
  const auto& [a, b, c] = piece.corners;
  return least_farthest(piece, search_.to(), std::array{a.slot, b.slot, c.slot}, search_.work());
}

const TriangleSet::Slots* TriangleSet::set_of(const Piece& piece) {
  if (const auto it = sets_.find(piece.triangle); it != sets_.end()) return &it->second;
  if (piece.depth > 0) return nullptr;
  Collected found = collect(piece);
  if (!found.complete) return nullptr;
  found.slots.shrink_to_fit();
  memory_bytes_ += found.slots.size() * sizeof(std::uint32_t) + sizeof(*sets_.begin());
  return &sets_.emplace(piece.triangle, std::move(found.slots)).first->second;
}

TriangleSet::Collected TriangleSet::collect(const Piece& whole) {
  const auto& [a, b, c] = whole.corners;
  Slots slots{a.slot, b.slot, c.slot};
  const double reach = least_farthest(whole, search_.to(), slots, search_.work()) + kSetMargin;

  const CornersAndFrame s = with_frame(a.point, b.point, c.point);
  Box box;
  for (const Vec3& v : s.corners) box.extend(v);
  std::vector<std::uint32_t> open{Bvh::kRoot};
  std::size_t tests = 0;
  while (!open.empty()) {
    const Bvh::Node& node = search_.to().nodes()[open.back()];
    open.pop_back();
    if (std::sqrt(box_distance_sq(box, node.box)) > reach) continue;
    if (!node.is_leaf()) {
      open.insert(open.end(), {node.first, node.first + 1});
      continue;
    }
    if ((tests += node.count) >= kPulseEvery) {
      tests = 0;
      if (search_.interrupted()) return {std::move(slots), false};
    }
    for (std::uint32_t slot = node.first; slot < node.first + node.count; ++slot) {
      const std::uint32_t t = search_.to().triangle(slot);
      const MeshView mesh = search_.to().mesh();
      const CornersAndFrame other{{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)},
                                  search_.to().prepared(slot)};
      if (triangle_distance(s, other) <= reach) slots.push_back(slot);
    }
  }
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  return {std::move(slots), true};
}

}  // namespace meshgauge
