#include "oracle/exact.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace meshgauge;
using namespace meshgauge::oracle;

namespace {

constexpr double kTiny = std::numeric_limits<double>::denorm_min();
constexpr double kHuge = 0x1p1020;

Corners corners(const Vec3& a, const Vec3& b, const Vec3& c) { return {exact(a), exact(b), exact(c)}; }

bool is(const Ratio& ratio, double numerator, double denominator = 1) { return ratio == Ratio{numerator, denominator}; }

double between(double low, double high, std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace

TEST_CASE("a double converts to an exact number and back") {
  for (const double x : {0.0, 1.0, -1.0, 0.1, -1e-300, 1e300, kTiny, -kTiny, kHuge, 0x1.fffffffffffffp-1022, 3e-320,
                         std::numeric_limits<double>::max()}) {
    CHECK(Dyadic(x).approximate() == x);
    CHECK(Dyadic(x).sign() == (x > 0) - (x < 0));
    CHECK(Dyadic(x) - Dyadic(x) == Dyadic(0.0));
  }
}

TEST_CASE("sums and products keep every bit") {
  const Dyadic sum = Dyadic(1e300) + Dyadic(kTiny);
  CHECK(sum > Dyadic(1e300));
  CHECK(sum - Dyadic(1e300) == Dyadic(kTiny));
  CHECK(Dyadic(0.1) + Dyadic(0.2) != Dyadic(0.3));  // the doubles, not the decimals that they print as
  CHECK(Dyadic(0.1) * Dyadic(10.0) > Dyadic(1.0));
  CHECK((Dyadic(kTiny) * Dyadic(kTiny)).sign() == 1);
  CHECK((Dyadic(kTiny) * Dyadic(kTiny)).approximate(2148) == 1);
  CHECK(Dyadic::power_of_two(-1074) == Dyadic(kTiny));
  CHECK(Dyadic(3.0).half() == Dyadic(1.5));
  CHECK(Dyadic(-5.0).magnitude() == 3);
}

TEST_CASE("random arithmetic agrees with integers") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 1000; ++i) {
    const auto a = static_cast<std::int64_t>(random() >> 34) - (1 << 29),
               b = static_cast<std::int64_t>(random() >> 34) - (1 << 29);
    const Dyadic x(static_cast<double>(a)), y(static_cast<double>(b));
    CHECK((x + y).approximate() == static_cast<double>(a + b));
    CHECK((x - y).approximate() == static_cast<double>(a - b));
    CHECK(x * y == Dyadic(static_cast<double>(a)) * Dyadic(static_cast<double>(b)));
    CHECK((x * y).sign() == (a > 0 ? 1 : a < 0 ? -1 : 0) * (b > 0 ? 1 : b < 0 ? -1 : 0));
    CHECK((x < y) == (a < b));
  }
}

TEST_CASE("squared distances to a triangle, region by region") {
  const Corners t = corners({0, 0, 0}, {4, 0, 0}, {0, 3, 0});
  CHECK(is(distance_sq(exact({1, 1, 2}), t), 4));        // above the inside
  CHECK(is(distance_sq(exact({1, 1, 0}), t), 0));        // inside
  CHECK(is(distance_sq(exact({2, 0, 0}), t), 0));        // on an edge
  CHECK(is(distance_sq(exact({0, 3, 0}), t), 0));        // at a corner
  CHECK(is(distance_sq(exact({1, -2, 1}), t), 5));       // beside an edge
  CHECK(is(distance_sq(exact({-1, -2, -2}), t), 9));     // beyond a corner
  CHECK(is(distance_sq(exact({4, 3, 0}), t), 144, 25));  // beside the long edge: (12/5)^2
  CHECK(is(distance_sq(exact({7, -1, 0}), t), 10));      // beyond the acute corner
}

TEST_CASE("the order of the corners does not matter") {
  std::mt19937_64 random(8);
  for (int i = 0; i < 200; ++i) {
    const auto point = [&] { return exact({between(-1, 1, random), between(-1, 1, random), between(-1, 1, random)}); };
    const Point p = point(), a = point(), b = point(), c = point();
    const Ratio d = distance_sq(p, {a, b, c});
    CHECK(d == distance_sq(p, {b, c, a}));
    CHECK(d == distance_sq(p, {c, b, a}));
  }
}

TEST_CASE("degenerate triangles are segments and points") {
  const Point p = exact({1, 2, 2});
  CHECK(is(distance_sq(p, corners({0, 0, 0}, {0, 0, 0}, {0, 0, 0})), 9));
  CHECK(is(distance_sq(p, corners({0, 0, 0}, {3, 0, 0}, {0, 0, 0})), 8));
  CHECK(is(distance_sq(p, corners({0, 0, 0}, {3, 0, 0}, {1, 0, 0})), 8));
  CHECK(is(distance_sq(p, corners({-5, 0, 0}, {-5, 0, 0}, {-1, 0, 0})), 12));
}

TEST_CASE("slivers of any width, tiny and huge coordinates") {
  // One ulp wide: the nearest point is on the far side, a distance that no double can tell from the near one.
  const Corners sliver = corners({0, 0, 0}, {1, 0, 0}, {0.5, 0x1p-1074, 0});
  CHECK(distance_sq(exact({0.5, 1, 0}), sliver) <
        distance_sq(exact({0.5, 1, 0}), corners({0, 0, 0}, {1, 0, 0}, {0.5, 0, 0})));
  const Corners tiny = corners({0, 0, 0}, {kTiny, 0, 0}, {0, kTiny, 0});
  CHECK(distance_sq(exact({kTiny, kTiny, 0}), tiny) == Ratio{Dyadic(kTiny) * Dyadic(kTiny), 2.0});
  const Corners huge = corners({kHuge, 0, 0}, {0, kHuge, 0}, {0, 0, kHuge});
  CHECK(distance_sq(exact({0, 0, 0}), huge) == Ratio{Dyadic(kHuge) * Dyadic(kHuge), 3.0});
  CHECK(distance_sq(exact({0, 0, 0}), huge).approximate_root() == doctest::Approx(kHuge / std::sqrt(3.0)));
  CHECK(distance_sq(exact({kTiny, kTiny, 0}), tiny).approximate_root() == kTiny);  // 0.7 of it, rounded
}

TEST_CASE("a point of a triangle is at distance 0 of it, exactly") {
  std::mt19937_64 random(9);
  for (int i = 0; i < 200; ++i) {
    const auto point = [&] {
      return exact({between(-1, 1, random), between(-1, 1, random), between(-1e9, 1, random)});
    };
    const Corners t{point(), point(), point()};
    const double first = between(0, 1, random), second = between(0, 1, random) * (1 - first);
    if (!are_inside({first, second})) continue;
    CHECK(distance_sq(point_at(t, {first, second}), t).numerator.sign() == 0);
  }
  CHECK(are_inside({0.5, 0.5}));
  CHECK_FALSE(are_inside({0.5, 0x1.0000000000001p-1}));
  CHECK_FALSE(are_inside({-kTiny, 0}));
}

TEST_CASE("bounds are compared with roots exactly") {
  const Ratio half{1.0, 2.0};  // sqrt = 0.70710678118654752440..., the double nearest to it lies above
  const double above = 0.70710678118654757, below = std::nextafter(above, 0.0);
  CHECK(root_at_most(half, above));
  CHECK_FALSE(root_at_least(half, above));
  CHECK(root_at_least(half, below));
  CHECK_FALSE(root_at_most(half, below));
  CHECK(root_at_least({4.0, 1.0}, 2));
  CHECK(root_at_most({4.0, 1.0}, 2));
}

TEST_CASE("differences of roots are compared exactly") {
  CHECK(difference_at_least({9.0, 1.0}, {4.0, 1.0}, 1));
  CHECK_FALSE(difference_at_least({9.0, 1.0}, {4.0, 1.0}, std::nextafter(1.0, 2.0)));
  CHECK(difference_at_least({9.0, 1.0}, {4.0, 1.0}, 0));
  CHECK_FALSE(difference_at_least({4.0, 1.0}, {9.0, 1.0}, 0));
  // sqrt(2) - sqrt(1/2) = sqrt(1/2)
  CHECK_FALSE(difference_at_least({2.0, 1.0}, {1.0, 2.0}, 0.70710678118654757));
  CHECK(difference_at_least({2.0, 1.0}, {1.0, 2.0}, std::nextafter(0.70710678118654757, 0.0)));
  CHECK(difference_at_least({4.0, 1.0}, {0.0, 1.0}, 2));
}
