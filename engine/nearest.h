// Closest-point queries against a tree.
#pragma once

#include <cstdint>
#include <limits>

#include "engine/bvh.h"

namespace meshgauge {

struct Nearest {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  double distance = std::numeric_limits<double>::infinity();  // to `point`, computed; rounding.h R3
  std::uint32_t slot = kNone;                                 // the triangle that owns `point`, in the tree's mesh
  Vec3 point = Vec3::Zero();

  bool known() const { return slot != kNone; }
};

// The point of the tree's mesh closest to p. `triangle_tests` counts point-triangle distances. The returned
// distance is an upper bound of d(p, mesh) within rounding::kDistanceSlack + residual whatever happens, and in
// practice within the same of being equal to it. `hint` is a triangle that may be near: the closer it is, the less of
// the tree is entered. Thread safe.
Nearest nearest(const Bvh& tree, const Vec3& p, std::uint64_t& triangle_tests, std::uint32_t hint = Nearest::kNone);

// Distance from p to one prepared triangle, computed; R3 again.
inline double distance(const PreparedTriangle& triangle, const Vec3& p) {
  return (p - closest_point(triangle, p)).norm();
}

// A certified lower bound of d(p, mesh): rounding.h, R5 and R6. Not above the true distance whatever the shape of the
// triangles, and within a few units of rounding below it. Thread safe.
double certified_distance_below(const Bvh& tree, const Vec3& p);

}  // namespace meshgauge
