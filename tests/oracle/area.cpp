#include "oracle/area.h"

#include <algorithm>
#include <cmath>

#include "oracle/long_triangle.h"

namespace meshgauge::oracle {
namespace {

class CellMaker {
 public:
  CellMaker(const Mesh& to, int depth, long double limit, int limit_depth)
      : to_(long_triangles(to)), depth_(depth), limit_(limit), limit_depth_(limit_depth) {}

  void add(const LongTriangle& t, long double area, int level) {
    const Point3 centre = (t[0] + t[1] + t[2]) / 3;
    const long double distance = to_nearest(centre, to_);
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
