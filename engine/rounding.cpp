#include "engine/rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace meshgauge::rounding {

double down(double x) { return std::nextafter(x, -std::numeric_limits<double>::infinity()); }
double up(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }

// ldexp is exact unless the result is subnormal; then it rounds to nearest, and scaling back, which is exact, shows in
// which direction.
double scale_up(double x, int exponent) {
  const double scaled = std::ldexp(x, exponent);
  return std::ldexp(scaled, -exponent) < x ? up(scaled) : scaled;
}

double scale_down(double x, int exponent) {
  const double scaled = std::ldexp(x, exponent);
  return std::ldexp(scaled, -exponent) > x ? std::nextafter(scaled, 0.0) : scaled;
}

// A rounded sum is at most one neighbour away from the exact one.
double add_up(double a, double b) { return up(a + b); }

double subtract_down(double a, double b) { return std::max(0.0, down(a - b)); }

}  // namespace meshgauge::rounding
