#include "engine/extras/display/deviation.h"

#include <algorithm>
#include <limits>

#include <doctest/doctest.h>

#include "engine/extras/display/refinement.h"
#include "engine/hausdorff.h"
#include "engine/rounding.h"
#include "oracle/exact.h"
#include "oracle/sides.h"
#include "shapes.h"
#include "today.h"

using namespace meshgauge;

namespace {

Deviation deviation_of(const Mesh& from, const Mesh& to, const DeviationOptions& options = {}) {
  Control control;
  auto found = deviation(Prepared(from), Prepared(to), options, control);
  REQUIRE(found.has_value());
  return std::move(*found);
}

// Checks each distance against the exact one to all triangles, and against that to the triangle that it names.
void check_against_all(const Mesh& from, const Mesh& to, double size) {
  const oracle::Surface surface = oracle::surface_of(to);
  const Deviation found = deviation_of(from, to);
  const double slack = 512 * rounding::kUnit * size;
  for (std::size_t v = 0; v < from.positions.size(); ++v) {
    const auto exact = oracle::distance_sq(oracle::exact(from.positions[v]), surface);
    CHECK(std::abs(found.distances[v] - exact.approximate_root()) <= slack);
    const auto of_named = oracle::distance_sq(oracle::exact(from.positions[v]), {surface[found.nearest[v]]});
    CHECK(std::abs(of_named.approximate_root() - exact.approximate_root()) <= slack);
  }
  CHECK(found.distances[found.farthest] == *std::max_element(found.distances.begin(), found.distances.end()));
}

bool all_zero(const Deviation& deviation) {
  return std::all_of(deviation.distances.begin(), deviation.distances.end(), [](double d) { return d == 0; });
}

}  // namespace

TEST_CASE("deviation: distances agree with exact arithmetic over all triangles, in the meshes' unit") {
  std::mt19937_64 random(1);
  for (const double scale : {1.0, 3e-7, 5e11}) {
    const auto at = [&](const Mesh& mesh) { return shapes::scaled(mesh, scale); };
    check_against_all(at(shapes::sphere(6, 1.1)), at(shapes::sphere(5)), 4 * scale);
    check_against_all(at(shapes::soup(40, random)), at(shapes::soup(60, random)), 4 * scale);
  }
  const Vec3 far_away(1e6, -3e6, 2);
  check_against_all(shapes::moved(shapes::cube(1.25), far_away), shapes::moved(shapes::sphere(5), far_away), 8);
}

TEST_CASE("deviation: a vertex that both meshes have is at distance 0, and so is every vertex of the same mesh") {
  std::mt19937_64 random(2);
  for (const Mesh& mesh : {shapes::sphere(20, 0.3, {7, 1, 1}), shapes::soup(300, random), shapes::cube()}) {
    CHECK(all_zero(deviation_of(mesh, mesh)));
    Mesh stirred = mesh;
    std::shuffle(stirred.triangles.begin(), stirred.triangles.end(), random);
    CHECK(all_zero(deviation_of(mesh, stirred)));
  }
  CHECK(all_zero(deviation_of(shapes::grid(8, 1, 0), shapes::grid(8, 1, 0, true))));  // same corners, no same triangle
}

TEST_CASE("deviation: a vertex that no triangle uses is not part of the surface") {
  Mesh mesh = shapes::cube();
  mesh.positions.emplace_back(1e9, 0, 0);
  const Deviation found = deviation_of(mesh, shapes::cube(1, {0.25, 0, 0}));
  CHECK(found.distances.back() == 0);
  CHECK(found.nearest.back() == Deviation::kNone);
  CHECK(found.distances[0] == 0.25);
  CHECK(found.distances[1] == 0);
  CHECK(found.farthest == 0);
}

TEST_CASE("deviation: distances do not depend on threads or instruction sets") {
  const Mesh from = shapes::sphere(40, 1.01), to = shapes::sphere(37);
  const Deviation one = deviation_of(from, to);
  for (const std::string_view simd : supported_simd()) {
    const Deviation other = deviation_of(from, to, {3, simd});
    CHECK(other.distances == one.distances);
  }
}

TEST_CASE(
    "deviation: the farthest vertex is within the certified distance, and the trees of the measurement are reused") {
  const Mesh from = shapes::sphere(30, 1.02), to = shapes::sphere(25);
  const Prepared a(from), b(to);
  Control control;
  const Outcome outcome = measure(a, b, {}, control);
  const auto found = deviation(a, b, {2, "auto"}, control);
  REQUIRE(found.has_value());
  CHECK(found->distances[found->farthest] <= outcome.a_to_b->bounds.upper);
  CHECK(found->distances[found->farthest] > 0.015);
}

TEST_CASE("deviation: no distance exceeds the certified bound when rounding alone causes distances") {
  for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1e6, -1e6, 1e6)}) {
    const Mesh to = shapes::moved(shapes::sphere(12), offset);
    const Mesh from = refined(to, {0.05, 10'000}).value();
    const Deviation free = deviation_of(from, to);
    REQUIRE(free.distances[free.farthest] > 0);
    const double upper = free.distances[free.farthest] / 2;
    const Deviation bound = deviation_of(from, to, {1, "auto", upper});
    for (std::size_t v = 0; v < from.positions.size(); ++v) {
      CHECK(bound.distances[v] == std::min(free.distances[v], upper));
    }
    CHECK(all_zero(deviation_of(from, to, {1, "auto", 0})));
  }
}

TEST_CASE("deviation: an interruption at any check stops it and leaves no incomplete structure") {
  const Mesh from = shapes::scaled(shapes::closed_sphere(30), 1.3), to = shapes::closed_sphere(30);
  DeviationOptions with_sides{2, "auto"};
  with_sides.sides = true;
  Control all;
  const auto whole = deviation(Prepared(from), Prepared(to), with_sides, all);
  REQUIRE(whole.has_value());
  REQUIRE(whole->sides.size() == from.positions.size());
  REQUIRE(all.checks() > 10);
  for (std::uint64_t n = 1; n <= all.checks(); n += all.checks() / 10) {
    Control control;
    control.cancel_at_check(n);
    CHECK_FALSE(deviation(Prepared(from), Prepared(to), with_sides, control).has_value());
  }
  const Prepared a(from), b(to);
  Control interrupted, control;
  interrupted.cancel_at_check(all.checks() / 2);
  CHECK_FALSE(deviation(a, b, with_sides, interrupted).has_value());
  const auto again = deviation(a, b, with_sides, control);
  CHECK(again->distances == whole->distances);
  CHECK(again->sides == whole->sides);
}

TEST_CASE("deviation: each side is the exact one, and only a vertex on the surface or within its rounding has none") {
  std::mt19937_64 random(3);
  const Mesh solid = shapes::closed_sphere(6);
  const Mesh hollow = shapes::joined(solid, shapes::turned(shapes::scaled(solid, 0.5)));
  const Mesh both = shapes::joined(solid, shapes::moved(solid, {0.75, 0.125, 0}));
  Mesh points = shapes::soup(30, random);
  points.positions.insert(points.positions.end(), solid.positions.begin(), solid.positions.end());
  points.triangles = points_as_triangles(points.positions.size());
  std::uint64_t number = 0;
  for (const Mesh& from : {points, shapes::scaled(shapes::sphere(6), 1.01)}) {
    for (const double scale : {1.0, 3e-7, 5e11}) {
      if (!is_of_today(number++, 2)) continue;
      for (const Mesh& closed : {solid, hollow, both, shapes::cube(2, {-1, -1, -1})}) {
        const Mesh a = shapes::scaled(from, scale), b = shapes::scaled(closed, scale);
        const oracle::Surface surface = oracle::surface_of(b);
        const Deviation found = deviation_of(a, b, {2, "auto", std::numeric_limits<double>::infinity(), true});
        REQUIRE(found.sides.size() == a.positions.size());
        CHECK(found.distances == deviation_of(a, b).distances);
        std::size_t proved = 0;
        for (std::size_t v = 0; v < a.positions.size(); ++v) {
          const auto winding = oracle::winding_number(oracle::exact(a.positions[v]), surface);
          const int exact = !winding ? 0 : *winding > 0 ? -1 : 1;
          if (found.sides[v] == 0) CHECK((exact == 0 || found.distances[v] < 1e-13 * scale));
          if (found.sides[v] != 0) CHECK(found.sides[v] == exact);
          proved += found.sides[v] != 0;
        }
        CHECK(4 * proved > a.positions.size());
      }
    }
  }
}

TEST_CASE("deviation: a mesh without sides gives none, a part that is inside out none within it") {
  const Mesh cube = shapes::cube(2, {-1, -1, -1});
  const DeviationOptions signs{1, "auto", std::numeric_limits<double>::infinity(), true};
  Mesh open = cube;
  open.triangles.pop_back();
  for (const Mesh& none : {open, shapes::turned(cube), shapes::grid(3)}) {
    CHECK(deviation_of(shapes::sphere(4), none, signs).sides.empty());
  }
  const Mesh beside = shapes::joined(cube, shapes::turned(shapes::moved(shapes::scaled(cube, 0.5), {4, 0, 0})));
  Mesh points{{{0, 0, 0}, {4, 0, 0}, {2, 0, 0}, {1, 1, 1}}, points_as_triangles(4)};
  CHECK(deviation_of(points, beside, signs).sides == std::vector<std::int8_t>{-1, 0, 1, 0});
  CHECK(deviation_of(points, beside).sides.empty());
  CHECK(deviation_of(cube, cube, signs).sides == std::vector<std::int8_t>(8, 0));
}

TEST_CASE("deviation: no sign within the error of a mesh that stands for another") {
  const Mesh cube = shapes::cube(2, {-1, -1, -1});
  const Mesh points{{{0, 0, 1.125}, {0, 0, 1.25}, {0, 0, 0.75}}, points_as_triangles(3)};
  const Prepared moved(MeshView(points.positions, points.triangles), Prepared::Use::once, nullptr, std::nullopt, 0.2);
  Control control;
  const auto found = deviation(moved, Prepared(cube), {1, "auto", 10, true}, control);
  REQUIRE(found.has_value());
  CHECK(found->sides == std::vector<std::int8_t>{0, 1, -1});
}
