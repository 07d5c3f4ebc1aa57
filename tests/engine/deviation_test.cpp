#include "engine/deviation.h"

#include <algorithm>

#include <doctest/doctest.h>

#include "engine/hausdorff.h"
#include "engine/refinement.h"
#include "engine/rounding.h"
#include "oracle/exact.h"
#include "shapes.h"

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
  const Mesh from = shapes::sphere(60, 1.3), to = shapes::sphere(60);
  Control all;
  const auto whole = deviation(Prepared(from), Prepared(to), {}, all);
  REQUIRE(whole.has_value());
  REQUIRE(all.checks() > 10);
  for (std::uint64_t n = 1; n <= all.checks(); n += all.checks() / 10) {
    Control control;
    control.cancel_at_check(n);
    CHECK_FALSE(deviation(Prepared(from), Prepared(to), {2, "auto"}, control).has_value());
  }
  const Prepared a(from), b(to);
  Control interrupted, control;
  interrupted.cancel_at_check(all.checks() / 2);
  CHECK_FALSE(deviation(a, b, {}, interrupted).has_value());
  CHECK(deviation(a, b, {}, control)->distances == whole->distances);
}
