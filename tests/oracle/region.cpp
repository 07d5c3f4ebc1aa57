#include "oracle/region.h"

#include <cmath>
#include <limits>
#include <queue>
#include <variant>

#include "oracle/long_triangle.h"

namespace meshgauge::oracle {
namespace {

// How far a point is inside of a region: the distance to its surface, negative outside; for a box at least as far.
long double depth(const Point3& p, const Region& region) {
  if (const auto* sphere = std::get_if<Sphere>(&region.shape))
    return static_cast<long double>(sphere->radius) - (p - sphere->centre.cast<long double>()).norm();
  const Box& box = std::get<Box>(region.shape);
  const Point3 low = p - box.low.cast<long double>(), high = box.high.cast<long double>() - p;
  return std::min(low.minCoeff(), high.minCoeff());
}

struct Cell {
  LongTriangle corners;
  long double high;
  bool operator<(const Cell& other) const { return high < other.high; }
};

template <class Inside>
RegionBracket search(const Mesh& from, const Mesh& to, const Inside& inside, long double slack, int cells) {
  const std::vector<LongTriangle> targets = long_triangles(to);
  RegionBracket bracket;
  std::priority_queue<Cell> queue;
  const auto add = [&](const LongTriangle& t) {
    const Point3 centre = (t[0] + t[1] + t[2]) / 3;
    const long double radius = std::max({(t[0] - centre).norm(), (t[1] - centre).norm(), (t[2] - centre).norm()});
    if (inside(centre) < -radius - slack) return;
    for (const Point3& p : {centre, t[0], t[1], t[2]}) {
      if (inside(p) <= slack) continue;
      bracket.low = std::max(bracket.low, to_nearest(p, targets));
      bracket.may_be_empty = false;
    }
    queue.push({t, to_nearest(centre, targets) + radius});
  };
  for (const LongTriangle& t : long_triangles(from)) add(t);
  for (; cells > 0 && !queue.empty() && queue.top().high > bracket.low * 1.001L; --cells) {
    const LongTriangle t = queue.top().corners;
    queue.pop();
    const Point3 ab = (t[0] + t[1]) / 2, bc = (t[1] + t[2]) / 2, ca = (t[2] + t[0]) / 2;
    for (const LongTriangle& quarter : {LongTriangle{t[0], ab, ca}, LongTriangle{ab, t[1], bc},
                                        LongTriangle{ca, bc, t[2]}, LongTriangle{ab, bc, ca}}) {
      add(quarter);
    }
  }
  bracket.is_empty = queue.empty() && bracket.may_be_empty;
  bracket.high = queue.empty() ? bracket.low : std::max(bracket.low, queue.top().high);
  return bracket;
}

}  // namespace

RegionBracket farthest_inside(const Mesh& from, const Mesh& to, const Region& region, long double slack, int cells) {
  return search(
      from, to, [&](const Point3& p) { return depth(p, region); }, slack, cells);
}

RegionBracket farthest_outside(const Mesh& from, const Mesh& to, std::span<const Region> regions, long double slack,
                               int cells) {
  const auto outside = [&](const Point3& p) {
    long double least = std::numeric_limits<long double>::infinity();
    for (const Region& region : regions) least = std::min(least, -depth(p, region));
    return least;
  };
  return search(from, to, outside, slack, cells);
}

}  // namespace meshgauge::oracle
