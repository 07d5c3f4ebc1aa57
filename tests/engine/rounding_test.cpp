#include "engine/rounding.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

using namespace meshgauge;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// By the definition, with the library's next number. Returns the bits: they tell 0 from -0.
std::uint32_t up(double x) {
  const auto f = static_cast<float>(x);
  return std::bit_cast<std::uint32_t>(static_cast<double>(f) < x ? std::nextafter(f, kInfinity) : f);
}
std::uint32_t down(double x) {
  const auto f = static_cast<float>(x);
  return std::bit_cast<std::uint32_t>(static_cast<double>(f) > x ? std::nextafter(f, -kInfinity) : f);
}

void check(double x) {
  CAPTURE(x);
  CHECK(std::bit_cast<std::uint32_t>(rounding::float_up(x)) == up(x));
  CHECK(std::bit_cast<std::uint32_t>(rounding::float_down(x)) == down(x));
}

}  // namespace

TEST_CASE("rounding: the nearest float on either side") {
  using Float = std::numeric_limits<float>;
  for (const float f : {0.0F, -0.0F, 1.0F, -1.0F, 1.5F, Float::denorm_min(), -Float::denorm_min(), Float::min(),
                        -Float::min(), 1 - Float::epsilon() / 2, -1 + Float::epsilon() / 2, Float::max() / 2}) {
    const auto x = static_cast<double>(f);
    check(x);
    check(std::nextafter(x, 1e300));
    check(std::nextafter(x, -1e300));
  }
  std::mt19937_64 random(7);
  for (int i = 0; i < 100'000; ++i) {
    const auto x = std::bit_cast<double>(random());
    if (std::isfinite(x)) check(std::ldexp(x, -std::ilogb(x) + static_cast<int>(random() % 300) - 180));
  }
}
