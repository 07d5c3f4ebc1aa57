// Closest-point queries against a tree.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "engine/tree/bvh.h"

namespace meshgauge {

// The result of a query.
struct Nearest {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  double distance = std::numeric_limits<double>::infinity();  // to `point`, computed; rounding.h R3
  std::uint32_t slot = kNone;                                 // the triangle of the tree's mesh that holds `point`
  Vec3 point = Vec3::Zero();
  bool complete = true;  // false: the query was stopped; `point` is a point of the mesh, but may not be the nearest

  bool known() const { return slot != kNone; }
};

// Returns the point of the tree's mesh closest to p. Its distance is never below d(p, mesh) by more than
// rounding::kDistanceSlack + tree.residual(), and in practice not above it by more either. p lies in the unit frame.
// Adds the number of computed point-triangle distances to `triangle_tests`. `hint`: a triangle that may be near, which
// saves entering most of the tree. `stop`: polled about every 0.1 ms; null: never. `enough`: at this distance the query
// ends, with a point that may not be the nearest. Thread safe.
Nearest nearest(const Bvh& tree, const Vec3& p, std::uint64_t& triangle_tests, std::uint32_t hint = Nearest::kNone,
                const Interrupted* stop = nullptr, double enough = 0);

// The computed distance from p to one prepared triangle: rounding.h R3.
inline double distance(const PreparedTriangle& triangle, const Vec3& p) { return norm(p - closest_point(triangle, p)); }

// Returns a certified lower bound of d(p, mesh), at most `most`: rounding.h R5 and R6. It is never above the true
// distance, whatever the shape of the triangles, and below the smaller of both by a few units of rounding. nullopt:
// `stop`, which is polled about every 0.1 ms, returned true. Thread safe.
std::optional<double> certified_distance_below(const Bvh& tree, const Vec3& p, const Interrupted* stop = nullptr,
                                               double most = std::numeric_limits<double>::infinity());

}  // namespace meshgauge
