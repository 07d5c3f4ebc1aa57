#include "api/base/figures.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

using namespace meshgauge::api;

namespace {

double read(const std::string& text) {
  double value = std::nan("");
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value).ptr;
  CHECK(end == text.data() + text.size());
  return value;
}

}  // namespace

TEST_CASE("numbers are written with few digits, in fixed notation where that is short") {
  CHECK(to_digits(0, 4) == "0");
  CHECK(to_digits(0.05, 4) == "0.05");
  CHECK(to_digits(100000, 4) == "100000");
  CHECK(to_digits(1234567, 3) == "1230000");
  CHECK(to_digits(0.000123456, 3) == "0.000123");
  CHECK(to_digits(-1.99996, 4) == "-2");
  CHECK(to_digits(1.5e-12, 4) == "1.5e-12");
  CHECK(to_digits(1e-6, 4) == "1e-6");
  CHECK(to_digits(2.5e9, 4) == "2.5e9");
  CHECK(to_digits(-1e300, 4) == "-1e300");
  CHECK(to_digits(std::numeric_limits<double>::infinity(), 4) == "unknown");
}

TEST_CASE("rounding down is never above, rounding up never below, and both are near") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(1, 10);
  std::uniform_int_distribution<int> exponent(-300, 300), digits(1, 17);
  for (int i = 0; i < 5000; ++i) {
    const double x = mantissa(random) * std::pow(10, exponent(random));
    const int n = digits(random);
    CAPTURE(x);
    CAPTURE(n);
    const double below = read(to_digits_below(x, n)), above = read(to_digits_above(x, n));
    REQUIRE(below <= x);
    REQUIRE(above >= x);
    REQUIRE(above - below <= 1.001 * std::pow(10, 1 - n) * x * 10);
  }
}

TEST_CASE("the text of an interval proves the same verdict as the interval") {
  const auto same = [](double lower, double upper, double limit) {
    CAPTURE(lower);
    CAPTURE(upper);
    CAPTURE(limit);
    const IntervalText text = to_text(lower, upper, limit);
    const double low = read(text.lower), high = read(text.upper), most = read(text.limit);
    CHECK(low <= lower);
    CHECK(high >= upper);
    CHECK((low > most) == (lower > limit));
    CHECK((high <= most) == (upper <= limit));
  };
  same(0.05000000001, 0.06, 0.05);
  same(0.04, 0.05, 0.05);
  same(0.04, 0.0499999999999, 0.05);
  same(std::nextafter(0.1, 1), 0.2, 0.1);
  same(0, 0, 0);
  same(0, std::numeric_limits<double>::denorm_min(), 0);
  same(1.0 / 3, 2.0 / 3, 0.4330127018922193);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double limit = uniform(random), near = limit * (1 + 1e-9 * (uniform(random) - 0.5));
    same(std::min(near, limit), std::max(near, limit), i % 2 ? limit : near);
  }
}

TEST_CASE("an interval has as many digits as tell its ends apart, and no more") {
  const IntervalText text = to_text(0.123456, 0.223456, 0.5);
  CHECK(text.both() == "0.1234 \xE2\x80\xA6 0.2235");
  CHECK(text.limit == "0.5");
  CHECK(to_text(0.02 - 1e-13, 0.02 + 1e-13, 0.5).upper == "0.0200001");
  CHECK(to_text(2, 2, 3).both() == "2");
  CHECK(to_text(2, std::numeric_limits<double>::infinity(), 3).upper == "unknown");
}

TEST_CASE("ends that are not finite are unknown") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK(to_text(-kInfinity, 2, kInfinity).both() == "unknown \xE2\x80\xA6 2");
  CHECK(to_text(1, kInfinity, 3).upper == "unknown");
  CHECK(to_digits_above(kInfinity, 3) == "unknown");
  CHECK(to_digits_below(-kInfinity, 3) == "unknown");
}

TEST_CASE("a point has seven digits of its largest coordinate, and at least four decimals") {
  CHECK(in_words(meshgauge::Vec3(0.16666667199, -0.5, 5.55e-17)) == "(0.1666667, -0.5, 0)");
  CHECK(in_words(meshgauge::Vec3(12.345678901, -1e-9, 3)) == "(12.34568, 0, 3)");
  CHECK(in_words(meshgauge::Vec3(1000000.05, 0, 0)) == "(1000000.05, 0, 0)");
  CHECK(in_words(meshgauge::Vec3(3e-7, 1.23456789e-6, 0)) == "(3e-7, 1.234568e-6, 0)");
  CHECK(in_words(meshgauge::Vec3(1e308, 0, 0)) == "(1e308, 0, 0)");
  CHECK(in_words(meshgauge::Vec3::Zero()) == "(0, 0, 0)");
}

TEST_CASE("counts, sizes and times as people write them") {
  CHECK(grouped(999) == "999");
  CHECK(grouped(1234567) == "1,234,567");
  CHECK(in_bytes(812) == "812 B");
  CHECK(in_bytes(1'440'000) == "1.44 MB");
  CHECK(in_time(3.14159) == "3.1 ms");
  CHECK(in_time(62'000) == "62 s");
}
