#include "api/formats/outline.h"

#include <algorithm>

namespace meshgauge::api {
namespace {

struct Edge {
  Point2 from, to;

  double low_x() const { return std::min(from.x, to.x); }
  double high_x() const { return std::max(from.x, to.x); }
  double low_y() const { return std::min(from.y, to.y); }
  double high_y() const { return std::max(from.y, to.y); }
};

bool may_cross(const Edge& a, const Edge& b) { return a.low_y() <= b.high_y() && b.low_y() <= a.high_y(); }

bool cross(const Edge& a, const Edge& b) {
  return orientation(a.from, a.to, b.from) * orientation(a.from, a.to, b.to) < 0 &&
         orientation(b.from, b.to, a.from) * orientation(b.from, b.to, a.to) < 0;
}

bool goes_up(const Point2& a, const Point2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

}  // namespace

// Convex: all turns are one way, and the edges change only twice between going up and going down the lexicographic
// order (with three or more changes the outline winds several times or runs back on itself). Two changes with a
// reversal, a turn by 180 degrees, among turns to the left need all edges after it to go down until it is closed, so
// there is no area.
Turns turns_of(std::span<const Point2> outline) {
  std::vector<Point2> corners;  // without repetitions
  corners.reserve(outline.size());
  for (const Point2& p : outline) {
    if (corners.empty() || !(p == corners.back())) corners.push_back(p);
  }
  while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
  const std::size_t n = corners.size();
  std::size_t left = 0, right = 0, changes = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 &a = corners[i], &b = corners[(i + 1) % n], &c = corners[(i + 2) % n];
    const int turn = orientation(a, b, c);
    left += turn > 0;
    right += turn < 0;
    changes += goes_up(a, b) != goes_up(b, c);
  }
  const bool one_way = left == 0 || right == 0;
  const bool on_one_line = left == 0 && right == 0;
  return {on_one_line || (one_way && changes == 2), !one_way};
}

bool crosses_itself(std::span<const Point2> outline, StepBudget& budget) {
  const std::size_t n = outline.size();
  std::vector<Edge> edges;
  edges.reserve(n);
  for (std::size_t i = 0; i < n; ++i) edges.push_back({outline[i], outline[i + 1 == n ? 0 : i + 1]});
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.low_x() < b.low_x(); });
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n && edges[j].low_x() <= edges[i].high_x(); ++j) {
      const bool near = may_cross(edges[i], edges[j]);
      if (!budget.spend(near ? 1 + kOrientationSteps : 1)) return false;
      if (near && cross(edges[i], edges[j])) return true;
    }
  }
  return false;
}

}  // namespace meshgauge::api
