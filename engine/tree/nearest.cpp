#include "engine/tree/nearest.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "engine/kernels/walk.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

// The separating-plane bound for one direction: min over corners of (w-v).n / |n|, without slack (R5).
double separation(const std::array<Vec3, 3>& corners, const Vec3& w, const Vec3& n) {
  return std::min({dot(w - corners[0], n), dot(w - corners[1], n), dot(w - corners[2], n)});
}

// Removes from `v` its component along the unit vector `e`; twice, so that the result is orthogonal to rounding.
Vec3 orthogonal(Vec3 v, const Vec3& e) {
  v -= dot(v, e) * e;
  v -= dot(v, e) * e;
  return v;
}

// The best separating direction is one of seven: the triangle's normal, or from the closest point of an edge's line, or
// from a corner. Each gives a valid bound, so trying them all needs no case distinction that rounding could get wrong.
double certified_distance_below(const std::array<Vec3, 3>& corners, const PreparedTriangle& t, const Vec3& w) {
  double best = 0;
  const auto attempt = [&](const Vec3& n) {
    const double length = norm(n);
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
    const double length = norm(edge);
    if (length > 0x1p-500) attempt(orthogonal(w - v, edge / length));
  }
  return best;
}

}  // namespace

Nearest nearest(const Bvh& tree, const Vec3& p, std::uint64_t& triangle_tests, std::uint32_t hint,
                const Interrupted* stop, double enough) {
  Closest best{std::numeric_limits<double>::infinity(), Nearest::kNone};
  if (hint != Nearest::kNone) {
    ++triangle_tests;
    best = {squared_norm(p - closest_point(tree.prepared(hint), p)), hint};
  }
  Polling polling(stop, triangle_tests, enough > 0 ? enough * enough : 0);
  best = tree.kernels().nearest(tree.view(), p.data(), best, triangle_tests, polling);
  const Vec3 point = closest_point(tree.prepared(best.slot), p);
  return {norm(p - point), best.slot, point, !polling.stopped()};
}

std::optional<double> certified_distance_below(const Bvh& tree, const Vec3& p, const Interrupted* stop, double most) {
  constexpr std::uint64_t kTestsOfOne = 8;  // one of these takes as long as so many of a query's tests
  double limit = most;
  std::uint64_t tests = 0;
  Polling polling(stop, tests);
  walk(tree.view(), p.data(), limit * limit, [&](std::uint32_t block) {
    for (std::uint32_t t = Bvh::block_begin(block); t < tree.block_end(block); ++t) {
      const std::array corners{tree.mesh().corner(t, 0), tree.mesh().corner(t, 1), tree.mesh().corner(t, 2)};
      limit = std::min(limit, certified_distance_below(corners, tree.prepared(t), p));
    }
    tests += kTestsOfOne * kLanes;
    if (polling.poll(tests)) return kEndWalk;
    return limit * limit;  // not subject to underflow: a positive limit is at least an ulp of kSeparationSlack
  });
  return polling.stopped() ? std::nullopt : std::optional(limit);
}

}  // namespace meshgauge
