#include "engine/rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace meshgauge::rounding {

// ldexp is exact unless the result is subnormal; then it rounds to nearest, and scaling back, which is exact, shows in
// which direction.
double scale_up(double x, int exponent) {
  const double scaled = std::ldexp(x, exponent);
  return std::ldexp(scaled, -exponent) < x ? std::nextafter(scaled, std::numeric_limits<double>::infinity()) : scaled;
}

double scale_down(double x, int exponent) {
  const double scaled = std::ldexp(x, exponent);
  return std::ldexp(scaled, -exponent) > x ? std::nextafter(scaled, 0.0) : scaled;
}

// A rounded sum is at most one neighbour away from the exact one.
double add_up(double a, double b) { return std::nextafter(a + b, std::numeric_limits<double>::infinity()); }

double subtract_down(double a, double b) {
  return std::max(0.0, std::nextafter(a - b, -std::numeric_limits<double>::infinity()));
}

float float_up(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

float float_down(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

}  // namespace meshgauge::rounding
