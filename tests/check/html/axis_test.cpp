#include "check/html/axis.h"

#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

using namespace meshgauge::check;

namespace {

Axis axis_of(std::initializer_list<double> values) { return axis_for(std::span(values.begin(), values.size())); }

}  // namespace

TEST_CASE("a linear axis begins at 0 and has room behind the largest value") {
  const Axis axis = axis_of({0, 0.4, 1});
  CHECK_FALSE(axis.logarithmic);
  CHECK(axis.low == 0);
  CHECK(axis.at(0) == 0);
  CHECK(axis.at(0.625) == doctest::Approx(0.5));
  CHECK(axis.at(1) == doctest::Approx(0.8));
}

TEST_CASE("values of several magnitudes get a logarithmic axis on which all of them are apart") {
  const Axis axis = axis_of({1e-6, 0.05, 3});
  CHECK(axis.logarithmic);
  CHECK(axis.at(1e-6) > 0.03);
  CHECK(axis.at(0.05) - axis.at(1e-6) > 0.3);
  CHECK(axis.at(3) - axis.at(0.05) > 0.1);
  CHECK(axis.at(3) < 0.97);
  CHECK(axis.at(0) == 0);
}

TEST_CASE("values close together are shown with their neighbourhood alone") {
  const Axis axis = axis_of({1, 1.01, 1.02});
  CHECK_FALSE(axis.logarithmic);
  CHECK(axis.low > 0.9);
  CHECK(axis.at(1.01) - axis.at(1) > 0.1);
  const Axis with_zero = axis_of({0, 1, 1.01});
  CHECK(with_zero.low == 0);
}

TEST_CASE("an axis maps whatever comes into its length, in order") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-320, 308);
  for (int i = 0; i < 2000; ++i) {
    const double a = std::pow(10, exponent(random)), b = std::pow(10, exponent(random)),
                 c = std::pow(10, exponent(random));
    const Axis axis = axis_of({a, b, c});
    CAPTURE(a);
    CAPTURE(b);
    CAPTURE(c);
    REQUIRE(std::isfinite(axis.low));
    REQUIRE(std::isfinite(axis.high));
    REQUIRE(axis.low < axis.high);
    for (const double x : {a, b, c, 0.0, std::numeric_limits<double>::infinity()}) {
      REQUIRE(axis.at(x) >= 0);
      REQUIRE(axis.at(x) <= 1);
    }
    REQUIRE((a < b ? axis.at(a) <= axis.at(b) : axis.at(b) <= axis.at(a)));
    const auto marks = ticks(axis);
    REQUIRE(marks.size() <= 9);
    for (const AxisTick& mark : marks) REQUIRE(std::isfinite(mark.value));
  }
  CHECK(axis_of({0, 0}).at(std::nan("")) == 0);
}

TEST_CASE("value() is the inverse of at()") {
  for (const Axis& axis : {Axis{false, 2, 5}, Axis{true, 1e-4, 10}}) {
    for (const double share : {0.0, 0.1, 0.5, 0.9}) CHECK(axis.at(axis.value(share)) == doctest::Approx(share));
  }
}

TEST_CASE("ticks are round numbers within the axis, written short") {
  const auto labels = [](const Axis& axis) {
    std::string all;
    for (const AxisTick& tick : ticks(axis)) all += tick.label + " ";
    return all;
  };
  CHECK(labels({false, 0, 1.25}) == "0 0.2 0.4 0.6 0.8 1 1.2 ");
  CHECK(labels({false, 0.93, 1.1}) == "0.95 1 1.05 1.1 ");
  CHECK(labels({true, 0.02, 60}) == "0.1 1 10 ");
  CHECK(labels({true, 0.9, 60}) == "1 2 5 10 20 50 ");
}
