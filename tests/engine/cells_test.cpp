// The cells of parts (engine/extras/area/part.h) against exact areas: each point of a part counts once, above its
// triangle.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/extras/area/part.h"
#include "engine/hausdorff.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

constexpr double kLeft = std::numbers::sqrt2;  // the distance t from a slope is where |x| = kLeft t, or kRight t
const double kRight = std::sqrt(5.0);

// A valley z = -x, z = x / 2 over these intervals of y, in rows.
Mesh valley(const std::vector<std::pair<double, double>>& intervals, std::uint32_t rows = 3) {
  Mesh mesh;
  for (const auto& [from, to] : intervals) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t j = 0; j <= rows; ++j) {
      const double y = from + (to - from) * j / rows;
      mesh.positions.insert(mesh.positions.end(), {{-1, y, 1}, {0, y, 0}, {1, y, 0.5}});
    }
    for (std::uint32_t j = 0; j < rows; ++j) {
      for (std::uint32_t i = 0; i < 2; ++i) {
        const std::uint32_t a = first + 3 * j + i, b = a + 1, c = a + 3, d = c + 1;
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
      }
    }
  }
  return mesh;
}

Mesh whole_valley() { return valley({{-1, 1}}); }

Mesh with_duplicates(Mesh mesh) {
  std::vector<Triangle> all;
  for (const Triangle& t : mesh.triangles) all.insert(all.end(), {t, {t[1], t[2], t[0]}, {t[1], t[0], t[2]}});
  mesh.triangles = all;
  return mesh;
}

Mesh with_degenerate(Mesh mesh) {
  std::vector<Triangle> all;
  for (const Triangle& t : mesh.triangles) all.insert(all.end(), {{t[0], t[1], t[1]}, {t[2], t[2], t[2]}, t});
  mesh.triangles = all;
  return mesh;
}

// The valley as a fan, with three more triangles that share two of its spokes and lie above it. The floods of some
// orders of them cover a half twice. 7 orders.
Mesh wound(std::size_t order) {
  Mesh mesh{{{0, 0, 0}, {2, 0, 1}, {0, 2, 0}, {-2, 0, 2}, {0, -2, 0}, {0, 2, 1}, {-2, 0, 3}},
            {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {0, 1, 5}, {0, 5, 6}, {0, 6, 4}}};
  std::rotate(mesh.triangles.begin(), mesh.triangles.begin() + static_cast<std::ptrdiff_t>(order),
              mesh.triangles.end());
  return mesh;
}

// The valley up to y, folded back above itself.
Mesh folded(double y) {
  Mesh mesh = valley({{-1, y}});
  const auto last = static_cast<std::uint32_t>(mesh.positions.size()) - 3, first = last + 3;
  mesh.positions.insert(mesh.positions.end(), {{-1, -1, 2}, {0, -1, 1}, {1, -1, 1.5}});
  for (std::uint32_t i = 0; i < 2; ++i) {
    mesh.triangles.insert(mesh.triangles.end(),
                          {{last + i, last + i + 1, first + i}, {last + i + 1, first + i + 1, first + i}});
  }
  return mesh;
}

// The triangle (-0.4, y) (0.4, y) (0, y + 0.8) in the plane z = 0.
struct Found {
  Part part;
  std::optional<CellParts> cells;
};

Found cells_over(const Mesh& b, double y = -0.4) {
  const Bvh tree = tree_of(b);
  ThreadPool pool(1);
  const Adjacency adjacency(b, pool);
  PartBounder bounder(tree, adjacency, 0, {}, 1e-6);
  Work work;
  const auto corner = [&](double at_x, double at_y) { return nearest_corner(tree, {at_x, at_y, 0}, work); };
  const Part part = bounder.whole({corner(-0.4, y), corner(0.4, y), corner(0, y + 0.8)}, 3, true, work);
  return {part, bounder.cells(part, 1000, work)};
}

// The area of a triangle of B, seen along z, over the part: both in the plane z = 0.
double area_over(const Part& part, const std::array<Vec3, 3>& seen) {
  const auto left = [](const Vec3& a, const Vec3& b, const Vec3& p) {
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  };
  if (left(seen[0], seen[1], seen[2]) == 0) return 0;
  const double turn = left(seen[0], seen[1], seen[2]) < 0 ? -1 : 1;
  std::vector<Vec3> polygon;
  for (const Corner& corner : part.corners) polygon.push_back(corner.point);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto height = [&](const Vec3& p) { return turn * left(seen[i], seen[(i + 1) % 3], p); };
    std::vector<Vec3> kept;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
      if (height(p) >= 0) kept.push_back(p);
      if (height(p) * height(q) < 0) kept.push_back(p + height(p) / (height(p) - height(q)) * (q - p));
    }
    polygon = kept;
  }
  double sum = 0;
  for (std::size_t k = 2; k < polygon.size(); ++k) sum += left(polygon[0], polygon[k - 1], polygon[k]) / 2;
  return sum;
}

// `covers_once`: so the cells under a triangle are all that it lies over.
void check_areas(const Mesh& b, const Found& found, bool covers_once) {
  constexpr double kRound = 1e-12, kArea = 0.32;
  const double whole = found.part.weight;
  const auto& [parts, fans, error] = *found.cells;
  REQUIRE(error < 1e-9);
  double sum = 0;
  std::vector<double> under(b.triangles.size());
  for (const Part& cell : parts) {
    const std::uint32_t slot = cell.corners[0].slot;
    sum += cell.weight;
    under[slot] += cell.weight;
    CHECK(std::abs(cell.weight / whole -
                   area_over(found.part, {cell.corners[0].point, cell.corners[1].point, cell.corners[2].point}) /
                       kArea) <= kRound);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& p = cell.corners[i].point;
      const PreparedTriangle over = prepare(b.positions[b.triangles[slot][0]], b.positions[b.triangles[slot][1]],
                                            b.positions[b.triangles[slot][2]])
                                        .triangle;
      CHECK(std::abs(cell.enclosure.high[i] - distance(over, p)) <= kRound);
    }
  }
  CHECK(std::abs(sum - whole) <= error + kRound);
  for (std::size_t t = 0; t < under.size(); ++t) {
    CAPTURE(t);
    const Triangle& of = b.triangles[t];
    const double over =
        whole * area_over(found.part, {b.positions[of[0]], b.positions[of[1]], b.positions[of[2]]}) / kArea;
    CHECK(under[t] <= over + error + kRound);
    if (covers_once) CHECK(under[t] >= over - error - kRound);
  }
}

AreaBounds shares_of(const Mesh& a, const Mesh& b, const std::vector<double>& limits,
                     std::uint64_t work_items = 1U << 20, std::size_t memory_bytes = 1U << 28) {
  Options options;
  options.direction = Direction::a_to_b;
  options.max_work_items = work_items;
  options.max_memory_bytes = memory_bytes;
  options.areas.emplace().share_tolerance = 1e-4;
  for (const double limit : limits) options.areas->beyond.push_back({limit, {}});
  Control control;
  return *measure(a, b, options, control).areas->a_to_b;
}

}  // namespace

TEST_CASE("cells: they share out a part that B covers once") {
  for (const Mesh& b : {whole_valley(), with_degenerate(whole_valley()), valley({{-1, 0.5}, {0.55, 1}})}) {
    const Found found = cells_over(b);
    REQUIRE(found.cells);
    CHECK(found.cells->parts.size() >= 4);
    check_areas(b, found, true);
  }
}

TEST_CASE("cells: where B covers a part twice it has none, or those of one cover") {
  std::vector<Mesh> covers{with_duplicates(whole_valley()), folded(0.6)};
  for (std::size_t order = 0; order < 7; ++order) covers.push_back(wound(order));
  std::size_t refused = 0;
  for (const Mesh& b : covers) {
    const Found found = cells_over(b);
    found.cells ? check_areas(b, found, false) : void(++refused);
  }
  CHECK(refused > 0);
  CHECK(refused < covers.size());
}

TEST_CASE("cells: a part of which B misses as much as it covers twice has none") {
  Mesh half = whole_valley();
  std::erase_if(half.triangles, [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return half.positions[v].x() > 0; });
  });
  CHECK_FALSE(cells_over(half).cells);
  half.triangles.insert(half.triangles.end(), half.triangles.begin(), half.triangles.end());
  CHECK_FALSE(cells_over(half).cells);
}

TEST_CASE("cells: a part beyond a border, over a hole or under a fold's edge has none") {
  CHECK_FALSE(cells_over(valley({{-1, 0.2}})).cells);
  CHECK_FALSE(cells_over(valley({{-1, -0.1}, {0.1, 1}})).cells);
  CHECK_FALSE(cells_over(folded(0.2)).cells);
}

TEST_CASE("cells: shares beyond a limit of parts that B covers, misses and covers twice") {
  struct Case {
    Mesh b;
    double length;  // of y in [-0.4, 0.4] that B covers
    int ends;       // borders of B in there
  };
  std::vector<Case> cases{{whole_valley(), 0.8, 0},
                          {with_degenerate(whole_valley()), 0.8, 0},
                          {with_duplicates(whole_valley()), 0.8, 0},
                          {valley({{-1, 0.2}}), 0.6, 1},
                          {valley({{-0.25, 0.2}}), 0.45, 2},
                          {with_duplicates(valley({{-1, -0.15}, {0.15, 1}})), 0.5, 2},
                          {folded(0.2), 0.6, 1}};
  for (std::size_t order = 0; order < 7; ++order) cases.push_back({wound(order), 0.8, 0});
  for (std::size_t k = 0; k < cases.size(); ++k) {
    CAPTURE(k);
    const auto& [b, length, ends] = cases[k];
    for (const std::uint32_t n : {1U, 3U}) {
      const Mesh a = shapes::moved(shapes::grid(n, 0.8), {-0.4, -0.4, 0});
      const std::vector<double> limits{0.03, 0.07, 0.14};
      const AreaBounds found = shares_of(a, b, limits);
      CHECK(found.stop == AreaStop::complete);
      for (std::size_t i = 0; i < limits.size(); ++i) {
        CAPTURE(limits[i]);
        const double t = limits[i];
        const double within = (kLeft + kRight) * t * (length + ends * std::numbers::pi / 4 * t);
        CHECK(found.beyond[i].lower <= 1 - within / 0.64 + 1e-9);
        CHECK(found.beyond[i].upper >= 1 - within / 0.64 - 1e-9);
      }
    }
  }
}

TEST_CASE("cells: they are within what is left of the work items, and a round within the memory") {
  const Mesh a = shapes::moved(shapes::grid(1, 0.8), {-0.4, -0.4, 0}), b = valley({{-1, 1}}, 9);
  const std::vector<double> limits{0.03, 0.07};
  REQUIRE(shares_of(a, b, limits).pieces > 20);
  for (const unsigned items : {1U, 3U, 7U, 15U}) {
    CAPTURE(items);
    const AreaBounds found = shares_of(a, b, limits, items);
    CHECK(found.stop == AreaStop::budget);
    CHECK(found.pieces <= a.triangles.size() + items);
  }
  CHECK(shares_of(a, b, limits, 1000, 2000).pieces == a.triangles.size());
}
