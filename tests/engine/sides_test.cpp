// The extent on each side of a closed surface.
#include "engine/sides.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/extras/area/winding.h"
#include "engine/hausdorff.h"
#include "oracle/sides.h"
#include "same_outcome.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

using Why = NoSides::Why;

SideOutcome sides_of(const Mesh& a, const Mesh& b, Options options = {}) {
  options.direction = Direction::a_to_b;
  if (!options.sides) options.sides.emplace();
  Control control;
  return measure(a, b, options, control).sides.value();
}

SideOutcome in_zone(const Mesh& a, const Mesh& b, double inside, double outside, double uncertainty = 0,
                    bool narrow = false) {
  Options options;
  options.sides.emplace().limits = {inside, outside};
  options.uncertainty = uncertainty;
  options.narrow = narrow;
  return sides_of(a, b, options);
}

bool holds(const SideBounds& found, double value) {
  return found.lower <= value + 1e-12 && value - 1e-12 <= found.upper;
}

Why refused(const Mesh& b) { return sides_of(shapes::cube(0.5), b).refused.value().why; }

Mesh cloud(std::vector<Vec3> points) {
  const std::size_t count = points.size();
  return {std::move(points), points_as_triangles(count)};
}

const Mesh kCube = shapes::cube(2, {-1, -1, -1});

}  // namespace

TEST_CASE("sides: the upper bounds are finite, however early the search ends and however large the meshes are") {
  const double far = kMaxCoordinate;
  const Mesh huge = shapes::cube(2 * far, {-far, -far, -far});
  Options options;
  options.direction = Direction::a_to_b;
  options.sides.emplace();
  for (std::uint64_t at = 1; at < 40; ++at) {
    Control control;
    control.cancel_at_check(at);
    const SideOutcome found = measure(shapes::moved(kCube, {0.25, 0, 0}), huge, options, control).sides.value();
    CHECK(std::isfinite(found.outside.upper));
    CHECK(std::isfinite(found.inside.upper));
  }
}

TEST_CASE("sides: a cube that is moved along an axis") {
  const SideOutcome found = sides_of(shapes::moved(kCube, {0.25, 0, 0}), kCube);
  REQUIRE(!found.refused);
  CHECK(found.stop == AreaStop::complete);
  CHECK(holds(found.outside, 0.25));
  CHECK(holds(found.inside, 0.25));
  CHECK(found.outside.upper - found.outside.lower <= 0.01 * 0.25);
  CHECK(found.outside.at.value().x() > 1);
  CHECK(found.inside.at.value().x() < 0);
}

TEST_CASE("sides: a larger, a smaller and an equal solid reach to one side, or to none") {
  const SideOutcome larger = sides_of(shapes::scaled(kCube, 1.5), kCube);
  CHECK(holds(larger.outside, 0.5 * std::sqrt(3)));
  CHECK(larger.inside.upper <= 1e-3);
  CHECK(!larger.inside.at);
  const SideOutcome smaller = sides_of(shapes::scaled(kCube, 0.5), kCube);
  CHECK(holds(smaller.inside, 0.5));
  CHECK(smaller.outside.upper <= 1e-3);
  const SideOutcome equal = sides_of(kCube, kCube);
  CHECK(equal.inside.upper == 0);
  CHECK(equal.outside.upper == 0);
}

TEST_CASE("sides: faces that touch the baseline, or lie in it, do not stand in the way") {
  const Mesh beside = shapes::cube(2.0625, {-0.975, -1, -1});  // two faces lie in faces of the cube, and beyond
  const SideOutcome found = sides_of(beside, kCube);
  CHECK(found.stop == AreaStop::complete);
  CHECK(holds(found.inside, 0.025));
  CHECK(found.inside.upper <= 0.0253);
  CHECK(found.pieces < 10'000);
}

TEST_CASE("sides: a candidate that is open, and a point cloud") {
  const SideOutcome patch = sides_of(shapes::moved(shapes::grid(3), {0, 0, 1.125}), kCube);
  CHECK(holds(patch.outside, 0.125));
  CHECK(patch.inside.upper <= 1e-12);
  const SideOutcome points = sides_of(cloud({{0, 0, 0.75}, {0, 1.5, 0}, {1, 1, 1}}), kCube);
  CHECK(holds(points.outside, 0.5));
  CHECK(holds(points.inside, 0.25));
  CHECK(points.outside.triangle == 1);
  CHECK(points.inside.triangle == 0);
}

TEST_CASE("sides: a baseline that is open, not oriented, inside out or flat is refused with the reason") {
  Mesh open = kCube;
  open.triangles.pop_back();
  CHECK(refused(open) == Why::open);
  Mesh flipped = kCube;
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  CHECK(refused(flipped) == Why::flipped);
  CHECK(refused(shapes::joined(kCube, shapes::moved(kCube, {2, 2, 0}))) == Why::non_manifold);
  CHECK(refused(shapes::turned(kCube)) == Why::inside_out);
  const Mesh sheet = shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  CHECK(refused(shapes::joined(sheet, shapes::turned(sheet))) == Why::no_volume);
}

TEST_CASE("sides: a self-crossing baseline is the solid that it winds around") {
  const Mesh both = shapes::joined(kCube, shapes::moved(kCube, {1, 0.1, 0.1}));
  const SideOutcome found = sides_of(cloud({{0.5, 0, 0}, {-0.5, 0, 0}, {1.75, 0.1, 0.1}, {3, 0, 0}}), both);
  REQUIRE(!found.refused);
  CHECK(holds(found.inside, 0.5));  // the wall of the other cube counts
  CHECK(holds(found.outside, 1));
}

TEST_CASE("sides: a cavity is outside, a part that is inside out is refused where it matters") {
  const Mesh hollow = shapes::joined(kCube, shapes::turned(shapes::scaled(kCube, 0.5)));
  const SideOutcome cavity = sides_of(cloud({{0, 0, 0}, {0.75, 0, 0}}), hollow);
  CHECK(holds(cavity.outside, 0.5));
  CHECK(holds(cavity.inside, 0.25));
  const Mesh beside = shapes::joined(kCube, shapes::turned(shapes::moved(shapes::scaled(kCube, 0.5), {4, 0, 0})));
  const SideOutcome turned = sides_of(cloud({{4, 0, 0}}), beside);
  REQUIRE(turned.refused);
  CHECK(turned.refused->why == Why::part_inside_out);
  CHECK(turned.refused->at == Vec3(4, 0, 0));
  CHECK(!sides_of(cloud({{0, 0, 0}}), beside).refused);
}

TEST_CASE("sides: a gate of a zone is decided, each limit for its side") {
  const Mesh moved = shapes::moved(shapes::scaled(kCube, 1.0625), {0.125, 0, 0});  // 0.1875 outside, 0.0625 inside
  const auto exceeds = [&](double inside, double outside, double uncertainty = 0) {
    const SideOutcome found = in_zone(moved, kCube, inside, outside, uncertainty);
    CHECK(!found.refused);
    CHECK(found.stop == AreaStop::complete);
    return std::pair(found.inside.lower > inside + uncertainty, found.outside.lower > outside + uncertainty);
  };
  const double far = sides_of(moved, kCube).outside.lower;  // at a corner
  CHECK(exceeds(0.07, 1.1 * far) == std::pair(false, false));
  CHECK(exceeds(0.07, 0.9 * far).second);
  CHECK(exceeds(0.05, 1.1 * far).first);
  const SideOutcome pass = in_zone(moved, kCube, 0.07, 1.1 * far);
  CHECK(pass.inside.upper <= 0.07);
  CHECK(pass.outside.upper <= 1.1 * far);
  // An uncertainty leaves a band between both in which neither is said.
  const SideOutcome within = in_zone(moved, kCube, 0.07, 1.1 * far, 0.2 * far);
  CHECK(within.stop == AreaStop::complete);
  CHECK(within.outside.lower > 0.9 * far);
  CHECK(within.outside.upper <= 1.3 * far);
}

TEST_CASE("sides: after the verdict the intervals are narrowed") {
  const Mesh moved = shapes::moved(kCube, {0.125, 0, 0});
  const SideOutcome wide = in_zone(moved, kCube, 0.9, 0.9), narrow = in_zone(moved, kCube, 0.9, 0.9, 0, true);
  CHECK(wide.outside.lower == 0);
  CHECK(narrow.outside.lower > 0.11);
  CHECK(narrow.outside.upper < 0.14);
}

TEST_CASE("sides: every instruction set and number of threads gives the same bits") {
  const Mesh a = shapes::moved(shapes::sphere(9, 1.02), {0.05, 0, 0});
  const Mesh b = shapes::closed_sphere(12);
  const SideOutcome first = sides_of(a, b);
  REQUIRE(!first.refused);
  for (const std::string_view simd : supported_simd()) {
    Options options;
    options.simd = simd;
    const SideOutcome again = sides_of(a, b, options);
    CHECK(same_bits(first.outside.lower, again.outside.lower));
    CHECK(same_bits(first.outside.upper, again.outside.upper));
    CHECK(same_bits(first.inside.lower, again.inside.lower));
    CHECK(same_bits(first.inside.upper, again.inside.upper));
  }
}

TEST_CASE("sides: an interruption at any moment leaves intervals that hold") {
  const Mesh moved = shapes::moved(kCube, {0.25, 0.125, 0});
  for (std::uint64_t at = 1;; ++at) {
    Options options;
    options.direction = Direction::a_to_b;
    options.sides.emplace();
    Control control;
    control.cancel_at_check(at);
    const Outcome outcome = measure(moved, kCube, options, control);
    CHECK(outcome.sides->outside.upper >= 0.25);
    CHECK(outcome.sides->inside.upper >= 0.25);
    CHECK(outcome.sides->outside.lower <= outcome.upper);
    if (control.checks() < at) break;
    CHECK(outcome.sides->stop != AreaStop::budget);
  }
}

TEST_CASE("sides: a limit of the work is the reason to stop, and the intervals hold") {
  const Mesh a = shapes::closed_sphere(9, 1.05), b = shapes::closed_sphere(12);
  Options options;
  options.sides.emplace().length_tolerance = 1e-4;
  const SideOutcome whole = sides_of(a, b, options);
  REQUIRE(whole.stop == AreaStop::complete);
  for (const std::uint64_t limit : {0UL, 1UL, 100UL, 512UL}) {
    options.max_work_items = limit;
    const SideOutcome found = sides_of(a, b, options);
    CHECK(found.stop == AreaStop::budget);
    CHECK(found.outside.lower <= whole.outside.upper);
    CHECK(found.outside.upper >= whole.outside.lower);
  }
}

TEST_CASE("winding numbers equal exact ones, also on lines through edges and corners") {
  const Mesh solid = shapes::scaled(shapes::joined(shapes::joined(kCube, shapes::cube(1, {0.5, 0, 0})),
                                                   shapes::turned(shapes::cube(0.5, {-0.75, 0, 0}))),
                                    0.25);
  const Bvh tree = tree_of(solid);
  const oracle::Surface surface = oracle::surface_of(solid);
  Work work;
  int numbers[3] = {};
  for (int x = -9; x <= 9; ++x) {
    for (int y = -9; y <= 9; ++y) {
      for (int z = -9; z <= 9; ++z) {
        const Vec3 p = Vec3(x, y, z) / 20 + Vec3(0, 0, z % 2 == 0 ? 0.0 : 0x1p-40);
        const auto expected = oracle::winding_number(oracle::exact(p), surface);
        if (!expected) continue;
        CHECK(winding_number(tree, p, work) == expected);
        ++numbers[std::min(*expected, 2)];
      }
    }
  }
  for (const int count : numbers) CHECK(count > 0);
}
