#include "oracle/farthest.h"

#include <doctest/doctest.h>

#include <random>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::oracle;

namespace {

Surface surface(const Mesh& mesh) { return surface_of(mesh); }

// Checks sqrt(low) <= h <= sqrt(high), and that the distance found lies between them.
void check_contains(const Mesh& a, const Mesh& b, const Ratio& h_sq) {
  const Bracket bracket = exact_bracket(surface(a), surface(b), 60);
  CHECK(bracket.lower_sq <= h_sq);
  CHECK(bracket.upper_sq >= h_sq);
  const Farthest found = farthest_sample(surface(a), surface(b), 500);
  CHECK(found.distance_sq <= h_sq);
  CHECK(found.distance_sq.approximate_root() >= (1 - 1e-12) * h_sq.approximate_root());
}

}  // namespace

TEST_CASE("known distances lie in the bracket and are found") {
  const Mesh floor = shapes::grid(1, 4), high = shapes::moved(shapes::grid(1), {1, 1, 1});
  check_contains(high, floor, {1.0, 1.0});
  check_contains(floor, high, {9.0, 1.0});  // from the corner (4,4): 2, 2, 1
  check_contains(shapes::grid(1), shapes::moved(shapes::grid(1), {0.5, 0.5, 0}), {1.0, 2.0});
  check_contains(shapes::cube(), shapes::cube(), {0.0, 1.0});
  check_contains(shapes::grid(2), shapes::grid(1), {0.0, 1.0});
  check_contains(shapes::cube(2, {-0.5, -0.5, -0.5}), shapes::cube(), {3.0, 4.0});  // (1/2, 1/2, 1/2) beyond a corner
}

TEST_CASE("a farthest point inside a triangle is found: midway between two points, in the middle of a box") {
  Mesh points = shapes::triangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0});
  points.positions.emplace_back(2, 0, 0);
  points.triangles.push_back({3, 3, 3});
  check_contains(shapes::triangle({0, 0, 0}, {2, 0, 0}, {1, 0, 0}), points, {1.0, 1.0});
  check_contains(shapes::moved(shapes::grid(1), {0, 0, 0.5}), shapes::cube(), {1.0, 4.0});
  // Three points: the farthest is the centre of the circle through them, here (1, 1/2).
  points.positions.emplace_back(0, 1, 0);
  points.triangles.push_back({4, 4, 4});
  check_contains(shapes::triangle({0, 0, 0}, {2, 0, 0}, {0, 1, 0}), points, {5.0, 4.0});
}

TEST_CASE("the farthest point is found at any scale and offset, between slivers and points") {
  for (const double scale : {0x1p-1040, 0x1p-500, 0x1p-20, 0x1p500, 0x1p1015}) {
    const Ratio expected{Dyadic(scale) * Dyadic(scale), 2.0};
    check_contains(shapes::scaled(shapes::grid(1), scale),
                   shapes::scaled(shapes::moved(shapes::grid(1), {0.5, 0.5, 0}), scale), expected);
  }
  const Vec3 far(0x1p40, -0x1p30, 0x1p20);
  check_contains(shapes::moved(shapes::grid(1), far), shapes::moved(shapes::grid(1), far + Vec3(0.5, 0.5, 0)),
                 {1.0, 2.0});
}

TEST_CASE("a bracket narrows with every split and never inverts") {
  std::mt19937_64 random(11);
  for (int i = 0; i < 10; ++i) {
    const Surface a = surface(shapes::soup(2, random)), b = surface(shapes::soup(2, random));
    const Bracket wide = exact_bracket(a, b, 0), narrow = exact_bracket(a, b, 50);
    CHECK(wide.lower_sq <= narrow.lower_sq);
    CHECK(narrow.lower_sq <= narrow.upper_sq);
    CHECK(narrow.upper_sq <= wide.upper_sq);
    const Farthest found = farthest_sample(a, b, 1000);
    CHECK(found.distance_sq <= narrow.upper_sq);
    CHECK(found.distance_sq.approximate_root() >= narrow.lower_sq.approximate_root() * (1 - 1e-14));
  }
}
