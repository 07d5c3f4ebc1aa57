// Distances within regions, for shapes whose distances are known.
#include "engine/region.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "engine/hausdorff.h"
#include "engine/mesh/clipping.h"
#include "engine/mesh/pieces.h"
#include "engine/tree/prepared.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

Region box(const Vec3& low, const Vec3& high, std::optional<double> limit = {}) { return {Box{low, high}, limit}; }
Region sphere(const Vec3& centre, double radius) { return {Sphere{centre, radius}, {}}; }

Outcome measured(const Mesh& a, const Mesh& b, const std::vector<Region>& regions,
                 Direction direction = Direction::a_to_b, double tolerance = 1e-9) {
  Options options;
  options.direction = direction;
  options.tolerance = {tolerance, std::nullopt, std::nullopt};
  options.regions = regions;
  Control control;
  return measure(a, b, options, control);
}

bool holds(const RegionOutcome& found, double value, double width = 1e-8) {
  return found.lower <= value + 1e-12 && value - 1e-12 <= found.upper && found.upper - found.lower <= width;
}

// The square [0,1]^2, whose height over the plane z = 0 is x; in one piece.
Mesh ramp() { return {{{0, 0, 0}, {1, 0, 1}, {1, 1, 1}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}}; }
Mesh plane() { return shapes::moved(shapes::grid(4, 8), {-4, -4, 0}); }

constexpr double kAll = 10;

// Thin slabs across x, y and z in turn.
std::vector<Region> slabs(int n) {
  std::vector<Region> regions;
  for (int i = 0; i < n; ++i) {
    Vec3 low = Vec3::Constant(-2), high = Vec3::Constant(2);
    low[i % 3] = -1 + 2.0 * i / 64;
    high[i % 3] = low[i % 3] + 1e-3;
    regions.push_back(box(low, high));
  }
  return regions;
}

RegionPart outside(const Mesh& mesh, const std::vector<Region>& regions, std::size_t& polls, double resolution = 1e-7) {
  return part_of(mesh, 0, regions, Keep::outside, resolution, [&] { return ++polls > 1'000'000; }).value();
}

}  // namespace

TEST_CASE("regions: a box cuts triangles, and the rest is the complement") {
  const Outcome found = measured(ramp(), plane(), {box({0.25, -kAll, -kAll}, {0.5, kAll, kAll})});
  REQUIRE(found.regions.size() == 2);
  CHECK(holds(found.regions[0], 0.5));
  CHECK(holds(found.regions[1], 1));
  CHECK(found.lower == found.regions[1].lower);
  CHECK(found.upper == found.regions[1].upper);
  CHECK(found.stop == Stop::converged);
  const Outcome other = measured(ramp(), plane(), {box({0.5, -kAll, -kAll}, {kAll, kAll, kAll})});
  CHECK(holds(other.regions[0], 1));
  CHECK(holds(other.regions[1], 0.5));
}

TEST_CASE("regions: overlapping regions are measured each by itself") {
  const Outcome found =
      measured(ramp(), plane(), {box({-kAll, -kAll, -kAll}, {0.75, kAll, kAll}), sphere({0.5, 0.5, 0.5}, 0.25)});
  CHECK(holds(found.regions[0], 0.75));
  CHECK(holds(found.regions[1], 0.5 + 0.25 * std::sqrt(0.5)));
  CHECK(holds(found.regions[2], 1));
}

TEST_CASE("regions: a sphere's circle is met as closely as asked for, and the rest begins at it") {
  for (const double tolerance : {1e-2, 1e-5}) {
    const Outcome found = measured(ramp(), plane(), {sphere({1, 0.5, 1}, 0.5), sphere({0, 0.5, 0}, std::sqrt(1.25))},
                                   Direction::a_to_b, tolerance);
    CHECK(holds(found.regions[0], 1, tolerance));
    const double x = std::sqrt((1.25) / 2);  // along the middle, at 45 degrees
    CHECK(holds(found.regions[1], x, tolerance));
    CHECK(found.stop == Stop::converged);
  }
}

TEST_CASE("regions: the other mesh is the target as a whole") {
  const Mesh a = shapes::moved(shapes::grid(2), {0, 0, 0.5}), b = shapes::moved(shapes::grid(2), {3, 0, 0.5});
  // Nothing of b lies in the region, and yet the distance is to b.
  const Outcome found = measured(a, b, {box({0, 0, 0}, {1, 1, 1})}, Direction::symmetric);
  CHECK(holds(found.regions[0], 3));
  CHECK(found.regions[0].b_to_a->upper == 0);
  CHECK(holds(found.regions[1], 3));
  CHECK(found.regions[1].a_to_b->upper == 0);
}

TEST_CASE("regions: a surface in a face of a box is inside, to the last bit") {
  const Mesh cube = shapes::cube(0.1, {0.1, 0.2, 0.3});
  const double top = cube.positions[7].z();
  const Outcome on = measured(cube, plane(), {box({-kAll, -kAll, top}, {kAll, kAll, kAll})});
  CHECK(!on.regions[0].empty);
  CHECK(holds(on.regions[0], top));
  const double above = std::nextafter(top, kAll), below = std::nextafter(top, 0.0);
  CHECK(measured(cube, plane(), {box({-kAll, -kAll, above}, {kAll, kAll, kAll})}).regions[0].empty);
  // What lies in the face does not belong to the rest.
  const auto rest = part_of(cube, 0, std::vector<Region>{box({-kAll, -kAll, -kAll}, {kAll, kAll, top})}, Keep::outside,
                            1e-9, never_interrupted);
  CHECK(rest->sure.mesh.triangles.empty());
  CHECK(rest->doubtful.mesh.triangles.empty());
  const Outcome cut = measured(cube, plane(), {box({-kAll, -kAll, -kAll}, {kAll, kAll, below})});
  CHECK(holds(cut.regions[0], below));
  CHECK(holds(cut.regions[1], top));
}

TEST_CASE("regions: only a corner is inside") {
  const Mesh a = shapes::triangle({0, 0, 1}, {1, 0, 2}, {0, 1, 3});
  const Outcome found = measured(a, plane(), {box({-1, 0.5, 3}, {0, 2, 4}), sphere({0, 0, 1}, 0)});
  CHECK(holds(found.regions[0], 3));
  CHECK(found.regions[0].a_to_b->witness->point_a == Vec3(0, 1, 3));
  CHECK(found.regions[0].a_to_b->witness->triangle_a == 0);
  CHECK(found.regions[1].lower <= 1);
  CHECK(found.regions[1].upper >= 1);
  CHECK(holds(found.regions[2], 3));
}

TEST_CASE("regions: all or nothing of the surface") {
  const Mesh a = shapes::sphere(8, 1), b = shapes::sphere(5, 1.1);
  const Outcome whole = measured(a, b, {}, Direction::symmetric);
  CHECK(whole.regions.empty());
  for (const Region& all : {box(Vec3::Constant(-2), Vec3::Constant(2)), sphere(Vec3::Zero(), 2)}) {
    const Outcome found = measured(a, b, {all}, Direction::symmetric);
    CHECK(found.regions[0].lower <= whole.upper);
    CHECK(found.regions[0].upper >= whole.lower);
    CHECK(!found.regions[0].empty);
    CHECK(found.regions[1].empty);
    CHECK(found.regions[1].upper == 0);
  }
  for (const Region& nothing : {box(Vec3::Constant(2), Vec3::Constant(3)), sphere(Vec3::Zero(), 0.1)}) {
    const Outcome found = measured(a, b, {nothing}, Direction::symmetric);
    CHECK(found.regions[0].empty);
    CHECK(!found.regions[1].empty);
    CHECK(found.lower <= whole.upper);
    CHECK(found.upper >= whole.lower);
  }
}

TEST_CASE("regions: each has its limit, or that of the options") {
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {1e-9, std::nullopt, std::nullopt};
  options.max_distance = 2;
  options.regions = {box({0.25, -kAll, -kAll}, {0.5, kAll, kAll}, 0.4), box({-1, -1, -1}, {0.25, kAll, kAll}, 0.3)};
  Control control;
  const Outcome found = measure(ramp(), plane(), options, control);
  CHECK(found.regions[0].lower > 0.4);
  CHECK(found.regions[1].upper <= 0.3);
  CHECK(found.regions[2].upper <= 2);
}

TEST_CASE("regions: what rounding moved is neither inside nor outside for sure") {
  const double error = 1e-6;
  const Mesh a = ramp();
  const Prepared moved(a, Prepared::Use::once, nullptr, std::nullopt, error);
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {1e-4, std::nullopt, std::nullopt};
  options.regions = {box({-kAll, -kAll, -kAll}, {0.5, kAll, kAll}), box({1, -kAll, -kAll}, {kAll, kAll, kAll})};
  Control control;
  const Outcome found = measure(moved, Prepared(plane()), options, control);
  CHECK(found.regions[0].lower <= 0.5 - error);
  CHECK(found.regions[0].upper >= 0.5 + error);
  CHECK(found.regions[0].upper - found.regions[0].lower <= 1e-4);
  CHECK(found.regions[1].lower == 0);  // the edge at x = 1 may lie before it
  CHECK(found.regions[1].upper >= 1);
}

TEST_CASE("regions: the interval of a group is that of a mesh of its triangles alone") {
  std::mt19937_64 random(3);
  const Mesh a = shapes::sphere(9, 1.05);
  for (int round = 0; round < 20; ++round) {
    const Mesh b = shapes::soup(40, random);
    Group group;
    Mesh of_group{b.positions, {}}, rest{b.positions, {}};
    for (std::uint32_t t = 0; t < b.triangles.size(); ++t) {
      const bool is_in = random() % 3 == 0;
      (is_in ? of_group : rest).triangles.push_back(b.triangles[t]);
      if (is_in) group.ranges.push_back({t, t + 1});
    }
    const Outcome found = measured(a, b, {{group, {}}}, Direction::b_to_a);
    const Outcome alone = measured(a, of_group, {}, Direction::b_to_a),
                  other = measured(a, rest, {}, Direction::b_to_a);
    REQUIRE(found.regions.size() == 2);
    CHECK(found.regions[0].lower <= alone.upper);
    CHECK(found.regions[0].upper >= alone.lower);
    CHECK(found.regions[0].upper - found.regions[0].lower <= 1e-9);
    CHECK(group.has(found.regions[0].b_to_a->witness->triangle_a));
    CHECK(found.regions[1].lower <= other.upper);
    CHECK(found.regions[1].upper >= other.lower);
    CHECK(found.regions[1].upper - found.regions[1].lower <= 1e-9);
    CHECK(!group.has(found.regions[1].b_to_a->witness->triangle_a));
  }
}

TEST_CASE("regions: a group is of mesh b, and each point of mesh a is in the rest or a box") {
  Mesh b = shapes::moved(shapes::grid(1), {0, 0, 1});
  const Mesh lower = shapes::moved(shapes::grid(1), {0, 0, -3});
  const auto first = static_cast<std::uint32_t>(b.triangles.size());
  for (const Triangle& t : lower.triangles) {
    Triangle more;
    for (std::size_t i = 0; i < 3; ++i) more[i] = t[i] + static_cast<std::uint32_t>(b.positions.size());
    b.triangles.push_back(more);
  }
  b.positions.insert(b.positions.end(), lower.positions.begin(), lower.positions.end());
  const std::vector<Region> regions{{Group{"low", {{first, 2 * first}}}, {}},
                                    box({-kAll, -kAll, -kAll}, {0.5, kAll, kAll})};
  const Outcome found = measured(shapes::grid(1), b, regions, Direction::symmetric);
  REQUIRE(found.regions.size() == 3);
  CHECK(holds(found.regions[0], 3));
  CHECK(!found.regions[0].a_to_b);
  CHECK(holds(found.regions[1], 3));  // of both meshes, whatever groups there are
  CHECK(holds(found.regions[2], 1));
  CHECK(found.regions[2].a_to_b->upper >= 1);
  CHECK(found.upper >= found.regions[0].upper);
  const Outcome from_a = measured(shapes::grid(1), b, {regions[0]}, Direction::a_to_b);
  CHECK(from_a.regions[0].empty);
  CHECK(holds(from_a.regions[1], 1));
}

TEST_CASE("regions: an interruption at any moment leaves intervals that hold") {
  const Mesh a = ramp();
  const Mesh b = plane();
  for (std::uint64_t n = 1; n < 60; ++n) {
    Options options;
    options.direction = Direction::a_to_b;
    options.tolerance = {1e-5, std::nullopt, std::nullopt};
    options.regions = {sphere({1, 0.5, 1}, 0.5), box({0.25, -kAll, -kAll}, {0.5, kAll, kAll})};
    Control control;
    control.cancel_at_check(n);
    const Outcome found = measure(a, b, options, control);
    REQUIRE(found.regions.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
      const double exact[] = {1, 0.5, 1};
      CHECK(found.regions[i].lower <= exact[i] + 1e-12);
      CHECK(found.regions[i].upper >= exact[i] - 1e-12);
    }
  }
}

TEST_CASE("regions: progress is told of the whole") {
  Options options;
  options.direction = Direction::symmetric;
  options.regions = {box({0.25, -kAll, -kAll}, {0.5, kAll, kAll})};
  Control control;
  double lower = 0, least_upper = std::numeric_limits<double>::infinity();
  control.watch(
      [&](const Progress& progress) {
        lower = std::max(lower, progress.lower);
        least_upper = std::min(least_upper, progress.upper);
      },
      std::chrono::milliseconds(0));
  const Outcome found = measure(shapes::sphere(24, 1), shapes::sphere(7, 1.1), options, control);
  CHECK(lower <= found.upper);
  CHECK(least_upper >= found.lower);
  CHECK(control.report_due());  // the callback is back
}

TEST_CASE("regions: cuts by boxes are polled") {
  const Mesh a = shapes::triangle({0.591, 0.779, -1.72}, {0.120, -0.430, 1.16}, {0.388, -1.239, -0.407});
  std::size_t polls = 0;
  const RegionPart part = outside(a, slabs(64), polls);
  CHECK(part.sure.mesh.triangles.size() < 10'000);
  CHECK(part.doubtful.mesh.triangles.empty());
  CHECK(polls >= 4);
  const std::size_t all = polls;
  for (polls = 0; polls < all;) {
    const std::size_t last = polls + 1;
    polls = 0;
    CHECK(!part_of(a, 0, slabs(64), Keep::outside, 1e-7, [&] { return ++polls >= last; }));
    REQUIRE(polls == last);
  }
}

TEST_CASE("regions: a box cuts only the parts that it meets") {
  std::mt19937_64 random(1);
  const auto any = [&] { return std::ldexp(static_cast<double>(random() >> 11), -52) - 1; };
  std::vector<Region> regions;
  for (int i = 0; i < 64; ++i) {
    const Vec3 centre(any(), any(), any());
    const Vec3 half = Vec3::Constant(0.05 + 0.2 * std::abs(any()));
    regions.push_back(box(centre - half, centre + half));
  }
  std::size_t polls = 0;
  const RegionPart part = outside(shapes::scaled(shapes::soup(10, random), 2), regions, polls);
  CHECK(part.sure.mesh.triangles.size() < 10'000);
  CHECK(part.doubtful.mesh.triangles.empty());
}

TEST_CASE("regions: a piece counts once for the most pieces, through however many regions it passes") {
  std::vector<Region> balls;
  for (int i = 0; i < 64; ++i) balls.push_back(sphere({0.01 + i / 64.0, 0.01, 0}, 0.006));
  std::size_t polls = 0;
  const RegionPart part = outside(shapes::triangle({-1, -1, 0}, {3, -1, 0}, {0, 3, 0}), balls, polls, 1e-5);
  CHECK(part.sure.mesh.triangles.size() < kMostPieces / 16);
  CHECK(part.doubtful.mesh.triangles.empty());
}

TEST_CASE("regions: collecting what was kept is polled") {
  std::size_t polls = 0;
  const Mesh a = shapes::grid(96);
  const auto part = part_of(a, 0, std::vector<Region>{box({-1, -1, -1}, {2, 0.999, 1})}, Keep::inside, 1e-7, [&] {
    ++polls;
    return false;
  });
  CHECK(!part->whole);
  CHECK(polls >= 2 * (a.triangles.size() / 4096));
}

TEST_CASE("regions: an interval that only doubtful triangles keep open is not said to be converged") {
  const Mesh points{{{0, 0, 1}, {3, 0, 4}}, {{0, 0, 0}, {1, 1, 1}}};
  const Region ball = sphere({0, 0, 0}, 5);
  const Outcome found = measured(points, plane(), {ball}, Direction::a_to_b, 1e-6);
  CHECK(found.regions[0].lower <= 1);
  CHECK(found.regions[0].upper >= 4);
  CHECK(found.regions[0].stop == Stop::precision_floor);
  CHECK(found.regions[0].precision_floor >= 3);
  CHECK(found.stop == Stop::precision_floor);
  CHECK(found.precision_floor >= 3);
  CHECK(!found.met_by);

  // The rest has a point as far away, so the whole is known.
  const Mesh equal{{{-3.5, 0, 4}, {3, 0, 4}}, {{0, 0, 0}, {1, 1, 1}}};
  const Outcome known = measured(equal, plane(), {ball}, Direction::a_to_b, 1e-6);
  CHECK(known.regions[0].stop == Stop::precision_floor);
  CHECK(known.stop == Stop::converged);
  CHECK(known.precision_floor < 1e-6);

  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {1e-6, std::nullopt, std::nullopt};
  options.regions = {ball};
  Control control;
  const auto stop_at = [&](double limit) {
    options.max_distance = limit;
    return measure(points, plane(), options, control).regions[0].stop;
  };
  CHECK(stop_at(4.5) == Stop::gate_decided);
  CHECK(stop_at(0.5) == Stop::gate_decided);
  CHECK(stop_at(2) == Stop::precision_floor);
}

TEST_CASE("regions: the work of all parts together is limited") {
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {1e-9, std::nullopt, std::nullopt};
  options.max_work_items = 10;
  for (int i = 0; i < 8; ++i) options.regions.push_back(box({-2 + 0.5 * i, -2, -2}, {-1.5 + 0.5 * i, 2, 2}));
  Control control;
  const Outcome found = measure(shapes::sphere(24, 1), shapes::sphere(7, 1.1), options, control);
  CHECK(found.stop == Stop::budget);
  CHECK(found.a_to_b->work.subdivisions < 40);
}

TEST_CASE("regions: sides are searched for once, not in each part") {
  const Mesh a = shapes::closed_sphere(20, 1.01), b = shapes::closed_sphere(20);
  Options options;
  options.direction = Direction::a_to_b;
  const auto checks = [&] {
    Control control;
    measure(a, b, options, control);
    return control.checks();
  };
  options.sides.emplace();
  const std::uint64_t of_sides = checks();
  for (int i = 0; i < 8; ++i) options.regions.push_back(box({-2 + 0.5 * i, -2, -2}, {-1.5 + 0.5 * i, 2, 2}));
  const std::uint64_t of_both = checks();
  options.sides.reset();
  CHECK(2 * of_both < 3 * (of_sides + checks()));
}

TEST_CASE("regions: where rounding changes the sign more than twice, inside keeps one run and outside leaves out one") {
  Polygon polygon;
  for (const auto& [x, y] : {std::pair(0.0, -1.0), {2.0, -1e-17}, {3.0, 1e-17}, {4.0, -1e-17}, {5.0, 1.0}, {0.0, 1.0}})
    polygon.push_back({{x, y, 0}, Vec3::Zero()});
  const Plane plane{{0, 1, 0}, Vec3::Zero(), 0, 1};
  const Pieces left = within({polygon, polygon}, {plane, plane});
  CHECK(left.inner.size() == 4);
  for (const CutCorner& corner : left.inner) CHECK(corner.at.y() <= 0);
  CHECK(left.outer.size() == 6);
  CHECK(std::ranges::any_of(left.outer, [](const CutCorner& corner) { return corner.at.x() == 3; }));
  CHECK(gap(left) > 1);
}
