#include "engine/nearest.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

struct Entry {
  std::uint32_t node;
  double distance_sq;
};

// Visits leaves in the order of their boxes, nearest first within a node; `visit(node)` may lower the limit that
// `beyond(distance_sq)` compares with.
template <class Visit, class Beyond>
void descend(const Bvh& tree, const Vec3& p, Visit&& visit, Beyond&& beyond) {
  std::array<Entry, Bvh::kMaxDepth + 2> stack;
  std::size_t size = 0;
  stack[size++] = {Bvh::kRoot, distance_sq(tree.nodes()[Bvh::kRoot].box, p)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (beyond(entry.distance_sq)) continue;
    const Bvh::Node& node = tree.nodes()[entry.node];
    if (node.is_leaf()) {
      visit(node);
      continue;
    }
    Entry near{node.first, distance_sq(tree.nodes()[node.first].box, p)};
    Entry far{node.first + 1, distance_sq(tree.nodes()[node.first + 1].box, p)};
    if (far.distance_sq < near.distance_sq) std::swap(near, far);
    if (!beyond(far.distance_sq)) stack[size++] = far;
    stack[size++] = near;
  }
}

// The separating-plane bound for one direction: min over corners of (w-v).n / |n|, without slack (R5).
double separation(const std::array<Vec3, 3>& corners, const Vec3& w, const Vec3& n) {
  return std::min({(w - corners[0]).dot(n), (w - corners[1]).dot(n), (w - corners[2]).dot(n)});
}

// `v` without its part along the unit vector `e`; twice, so that the result is orthogonal to rounding.
Vec3 orthogonal(Vec3 v, const Vec3& e) {
  v -= v.dot(e) * e;
  v -= v.dot(e) * e;
  return v;
}

// The best separating direction is one of seven: the triangle's normal, or from the closest point of an edge's line,
// or from a corner. Each gives a valid bound, so trying them all needs no case distinction that rounding could get
// wrong.
double certified_distance_below(const std::array<Vec3, 3>& corners, const PreparedTriangle& t, const Vec3& w) {
  double best = 0;
  const auto attempt = [&](const Vec3& n) {
    const double length = n.norm();
    if (length > 0x1p-500) best = std::max(best, separation(corners, w, n / length) - rounding::kSeparationSlack);
  };
  attempt(w - closest_point(t, w));
  const Vec3 normal = t.e1.cross(t.e2);
  attempt(normal);
  attempt(-normal);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& v = corners[i];
    attempt(w - v);
    const Vec3 edge = corners[(i + 1) % 3] - v;
    const double length = edge.norm();
    if (length > 0x1p-500) attempt(orthogonal(w - v, edge / length));
  }
  return best;
}

}  // namespace

Nearest nearest(const Bvh& tree, const Vec3& p, std::uint64_t& triangle_tests, std::uint32_t hint) {
  Nearest best;
  double best_sq = std::numeric_limits<double>::infinity();
  const auto attempt = [&](std::uint32_t slot) {
    ++triangle_tests;
    const Vec3 q = closest_point(tree.prepared(slot), p);
    const double d_sq = (p - q).squaredNorm();
    if (d_sq < best_sq) best_sq = d_sq, best.slot = slot, best.point = q;
  };
  const auto visit = [&](const Bvh::Node& leaf) {
    for (std::uint32_t slot = leaf.first; slot < leaf.first + leaf.count; ++slot) attempt(slot);
  };
  if (hint != Nearest::kNone) attempt(hint);
  descend(tree, p, visit, [&](double box_sq) { return box_sq >= best_sq; });
  best.distance = std::sqrt(best_sq);
  return best;
}

// Triangles of a skipped box are farther than sqrt(box_sq) - kBoxSlack >= limit.
double certified_distance_below(const Bvh& tree, const Vec3& p) {
  double limit = std::numeric_limits<double>::infinity();
  const auto visit = [&](const Bvh::Node& leaf) {
    for (std::uint32_t slot = leaf.first; slot < leaf.first + leaf.count; ++slot) {
      const std::uint32_t t = tree.triangle(slot);
      const std::array corners{tree.mesh().corner(t, 0), tree.mesh().corner(t, 1), tree.mesh().corner(t, 2)};
      limit = std::min(limit, certified_distance_below(corners, tree.prepared(slot), p));
    }
  };
  descend(tree, p, visit, [&](double box_sq) { return std::sqrt(box_sq) - rounding::kBoxSlack >= limit; });
  return limit;
}

}  // namespace meshgauge
