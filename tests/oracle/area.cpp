#include "oracle/area.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

namespace meshgauge::oracle {
namespace {

using Point3 = Eigen::Matrix<long double, 3, 1>;
using LongTriangle = std::array<Point3, 3>;

LongTriangle long_triangle(const Mesh& mesh, const Triangle& t) {
  return {mesh.positions[t[0]].cast<long double>(), mesh.positions[t[1]].cast<long double>(),
          mesh.positions[t[2]].cast<long double>()};
}

long double to_segment(const Point3& p, const Point3& a, const Point3& b) {
  const Point3 ab = b - a;
  const long double length_sq = ab.squaredNorm();
  const long double s = length_sq > 0 ? std::clamp((p - a).dot(ab) / length_sq, 0.0L, 1.0L) : 0.0L;
  return (p - a - s * ab).norm();
}

// The distance to the plane where the foot is inside of all edges, else to the nearest edge.
long double to_triangle(const Point3& p, const LongTriangle& t) {
  const Point3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const long double length = normal.norm();
  long double least = std::min({to_segment(p, t[0], t[1]), to_segment(p, t[1], t[2]), to_segment(p, t[2], t[0])});
  if (!(length > 0)) return least;
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3& a = t[i];
    inside = inside && normal.dot((t[(i + 1) % 3] - a).cross(p - a)) >= 0;
  }
  if (inside) least = std::min(least, std::abs((p - t[0]).dot(normal)) / length);
  return least;
}

class CellMaker {
 public:
  CellMaker(const Mesh& to, int depth, long double limit, int limit_depth)
      : depth_(depth), limit_(limit), limit_depth_(limit_depth) {
    for (const Triangle& t : to.triangles) to_.push_back(long_triangle(to, t));
  }

  void add(const LongTriangle& t, long double area, int level) {
    const Point3 centre = (t[0] + t[1] + t[2]) / 3;
    long double distance = to_triangle(centre, to_[0]);
    for (const LongTriangle& other : to_) distance = std::min(distance, to_triangle(centre, other));
    const long double radius = std::max({(t[0] - centre).norm(), (t[1] - centre).norm(), (t[2] - centre).norm()});
    const bool passes = distance - radius <= limit_ && distance + radius > limit_;
    if (level >= depth_ && !(passes && level < limit_depth_)) {
      cells.push_back({std::max(distance - radius, 0.0L), distance + radius, area});
      return;
    }
    const Point3 ab = (t[0] + t[1]) / 2, bc = (t[1] + t[2]) / 2, ca = (t[2] + t[0]) / 2;
    for (const LongTriangle& quarter : {LongTriangle{t[0], ab, ca}, LongTriangle{ab, t[1], bc},
                                        LongTriangle{ca, bc, t[2]}, LongTriangle{ab, bc, ca}}) {
      add(quarter, area / 4, level + 1);
    }
  }

  std::vector<AreaCell> cells;

 private:
  std::vector<LongTriangle> to_;
  int depth_;
  long double limit_;
  int limit_depth_;
};

template <class Value>
AreaBracket cell_average(const std::vector<AreaCell>& cells, const Value& value) {
  long double low = 0, high = 0;
  for (const AreaCell& cell : cells) {
    low += cell.area * value(cell.low);
    high += cell.area * value(cell.high);
  }
  const long double area = total_area(cells);
  return {low / area, high / area};
}

}  // namespace

std::vector<AreaCell> area_cells(const Mesh& from, const Mesh& to, int depth, long double limit, int limit_depth) {
  CellMaker subdivision(to, depth, limit, limit_depth);
  for (const Triangle& t : from.triangles) {
    const LongTriangle corners = long_triangle(from, t);
    const long double area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2;
    if (area > 0) subdivision.add(corners, area, 0);
  }
  return std::move(subdivision.cells);
}

AreaBracket share_beyond(const std::vector<AreaCell>& cells, long double limit) {
  return cell_average(cells, [&](long double d) { return d > limit ? 1.0L : 0.0L; });
}

AreaBracket mean(const std::vector<AreaCell>& cells) {
  return cell_average(cells, [](long double d) { return d; });
}

AreaBracket rms(const std::vector<AreaCell>& cells) {
  const AreaBracket squares = cell_average(cells, [](long double d) { return d * d; });
  return {std::sqrt(squares.low), std::sqrt(squares.high)};
}

AreaBracket quantile(std::vector<AreaCell> cells, long double p) {
  const long double wanted = p * total_area(cells);
  const auto at = [&](auto end) {
    std::sort(cells.begin(), cells.end(), [&](const AreaCell& a, const AreaCell& b) { return a.*end < b.*end; });
    long double sum = 0;
    for (const AreaCell& cell : cells) {
      sum += cell.area;
      if (sum >= wanted) return cell.*end;
    }
    return cells.back().*end;
  };
  const long double low = at(&AreaCell::low);
  return {low, at(&AreaCell::high)};
}

long double total_area(const std::vector<AreaCell>& cells) {
  long double sum = 0;
  for (const AreaCell& cell : cells) sum += cell.area;
  return sum;
}

}  // namespace meshgauge::oracle
