#include "engine/paper/triangle_set.h"

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;

namespace {

CornersAndFrame make(const Vec3& a, const Vec3& b, const Vec3& c) { return {{a, b, c}, prepare(a, b, c).triangle}; }

double between(const CornersAndFrame& s, const CornersAndFrame& t) {
  const double d = triangle_distance(s, t);
  CHECK(triangle_distance(t, s) == doctest::Approx(d));
  return d;
}

// The distance by convex descent: alternates closest points between the two triangles, from many starts.
double reference(const CornersAndFrame& s, const CornersAndFrame& t, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  double best = std::numeric_limits<double>::infinity();
  for (int start = 0; start < 4; ++start) {
    Vec3 p = s.corners[0] * uniform(random);
    for (int i = 0; i < 3000; ++i) p = closest_point(s.prepared, closest_point(t.prepared, p));
    best = std::min(best, (p - closest_point(t.prepared, p)).norm());
  }
  return best;
}

}  // namespace

TEST_CASE("distance of triangles that are apart, touch, pierce and overlap") {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  const auto flat = make(o, x, y);
  CHECK(between(flat, make(o + z, x + z, y + z)) == doctest::Approx(1));
  CHECK(between(flat, flat) == 0);
  CHECK(between(flat, make(x, x + y, x + z)) == 0);                                     // one corner in common
  CHECK(between(flat, make({0.2, 0.2, -1}, {0.2, 0.3, 1}, {0.3, 0.2, 1})) == 0);        // pierced
  CHECK(between(flat, make({0.25, 0.25, 0}, {0.3, 0.25, 0}, {0.25, 0.3, 0})) < 1e-15);  // coplanar, inside
  CHECK(between(flat, make({-1, 0.25, 0}, {2, 0.25, 0}, {2, 0.26, 0})) == 0);  // coplanar, across, no corner inside
  CHECK(between(flat, make({0.25, 0.25, 0.5}, {0.25, 0.25, 0.5}, {0.25, 0.25, 0.5})) == doctest::Approx(0.5));
  CHECK(between(flat, make({-1, 2, 0.5}, {2, -1, 0.5}, {5, 5, 5})) == doctest::Approx(0.5));  // edge above edge
  CHECK(between(make(o, o, o), make(z, z, z)) == doctest::Approx(1));
}

TEST_CASE("distance of random triangles agrees with convex descent") {
  std::mt19937_64 random(13);
  for (int i = 0; i < 300; ++i) {
    const Mesh soup = shapes::soup(2, random);
    const auto corner = [&](std::size_t k) { return soup.positions[k]; };
    const auto s = make(corner(0), corner(1), corner(2)), t = make(corner(3), corner(4), corner(5));
    const double expected = reference(s, t, random);
    CHECK(between(s, t) <= expected + 1e-12);
    CHECK(between(s, t) >= expected - 2e-2);  // descent may be slow, never below
  }
}
