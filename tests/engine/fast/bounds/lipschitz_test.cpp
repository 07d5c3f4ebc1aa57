#include "engine/fast/bounds/lipschitz.h"

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;

TEST_CASE("the enclosing radius of known triangles") {
  const Vec3 o(0, 0, 0), x(1, 0, 0);
  CHECK(enclosing_radius(o, x, {0, 1, 0}) == doctest::Approx(std::sqrt(0.5)));                      // right
  CHECK(enclosing_radius(o, x, {0.5, std::sqrt(0.75), 0}) == doctest::Approx(1 / std::sqrt(3.0)));  // equilateral
  CHECK(enclosing_radius(o, x, {0.5, 0.1, 0}) == doctest::Approx(0.5));                             // obtuse
  CHECK(enclosing_radius(o, o, x) == doctest::Approx(0.5));
  CHECK(enclosing_radius(o, o, o) == 0);
}

TEST_CASE("no point of a triangle is farther than the radius from its nearest corner") {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> uniform(-1, 1), weight(0, 1);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int i = 0; i < 20000; ++i) {
    const double thin = std::pow(10.0, -16 * weight(random));
    const Vec3 a = point(), b = point(), c = (i % 3 == 0 ? a : point()) + thin * point();
    const double radius = enclosing_radius(a, b, c);
    for (int k = 0; k < 10; ++k) {
      double u = weight(random), v = weight(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 p = (1 - u - v) * a + u * b + v * c;
      CHECK(std::min({(p - a).norm(), (p - b).norm(), (p - c).norm()}) <= radius + 1e-15);
    }
  }
}
