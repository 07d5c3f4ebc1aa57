// How soon a measurement ends when it is asked to.
#include <doctest/doctest.h>

#include "engine/hausdorff.h"
#include "engine/kernels/kernels.h"
#include "engine/tree/nearest.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

// Copies of one triangle: all are equally far from a point, so a query tests every one.
Mesh stack(std::size_t copies) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles.assign(copies, {0, 1, 2});
  return mesh;
}

struct Asked {
  Strategy strategy;
  int points;
};
constexpr Asked kStrategies[] = {{Strategy::automatic, 4},
                                 {Strategy::four_point, 4},
                                 {Strategy::n_point, 31},
                                 {Strategy::n_point, 1585},
                                 {Strategy::triangle_set, 4}};

}  // namespace

TEST_CASE("interruption: a search polls within its queries, and ends soon after it was asked to") {
  const Mesh a = shapes::moved(shapes::sphere(6, 1), {0.2, 0.3, 4}), b = stack(1 << 17);
  for (const auto& [strategy, points] : kStrategies) {
    CAPTURE(points);
    for (const std::uint64_t at : {1U, 50U, 100U, 150U, 200U}) {
      CAPTURE(at);
      Options options;
      options.strategy = strategy;
      options.points = points;
      options.direction = Direction::a_to_b;
      options.tolerance = {1e-9, std::nullopt, std::nullopt};
      Control control;
      control.cancel_at_check(at);
      const Outcome out = measure(a, b, options, control);
      REQUIRE(out.stop == Stop::cancelled);
      CHECK(out.lower <= out.upper);
      // After the last check that lets it go on, at most a block of eight triangles with four queries each.
      constexpr std::uint64_t kQueries = 8 * 4;
      CHECK(out.a_to_b->work.triangle_tests <= (at + kQueries) * (kTestsBetweenPolls + kLanes));
    }
  }
}

TEST_CASE("interruption: the lower bound is certified during the search, so that an interruption finds one") {
  const Mesh a = shapes::moved(shapes::sphere(6, 1), {0.2, 0.3, 4}), b = stack(1 << 21);
  Options options;
  options.strategy = Strategy::n_point;
  options.points = 31;
  options.direction = Direction::a_to_b;
  Control control;
  control.cancel_at_check(20000);
  const Outcome out = measure(a, b, options, control);
  REQUIRE(out.stop == Stop::cancelled);
  CHECK(out.lower > 2);
  CHECK(out.lower <= out.upper);
}

TEST_CASE("interruption: a query that is stopped gives a point of the mesh, and no certified distance") {
  const Mesh mesh = stack(1 << 17);
  const Bvh tree = tree_of(mesh);
  const Vec3 p(0.1, 0.1, 0.5);
  int polls = 0;
  const Interrupted third = [&polls] { return ++polls == 3; };
  std::uint64_t tests = 0;
  const Nearest found = nearest(tree, p, tests, Nearest::kNone, &third);
  CHECK_FALSE(found.complete);
  CHECK(found.known());
  CHECK(tests == 3 * kTestsBetweenPolls);
  polls = 0;
  CHECK_FALSE(certified_distance_below(tree, p, &third).has_value());
  CHECK(polls == 3);
  const Interrupted never = never_interrupted;
  CHECK(nearest(tree, p, tests, Nearest::kNone, &never).complete);
  CHECK(certified_distance_below(tree, p, &never) == certified_distance_below(tree, p));
}
