// Decides exactly on which side of a line a point lies.
#pragma once

#include <cmath>
#include <span>
#include <vector>

namespace meshgauge::api {

struct Point2 {
  double x = 0;
  double y = 0;

  bool operator==(const Point2&) const = default;
};

// An unrounded sum of doubles and of products of two doubles: an expansion of parts that do not overlap, smallest first
// (Shewchuk 1997, grow-expansion). Exact while no product overflows and no nonzero product is below 2^-960.
class ExactSum {
 public:
  void add(double x);
  void add_product(double a, double b);
  int sign() const { return parts_.empty() ? 0 : (parts_.back() > 0 ? 1 : -1); }

 private:
  std::vector<double> parts_;
};

// Returns the sign by exact arithmetic, for cases that the filter of orientation() cannot decide.
int exact_orientation(const Point2& a, const Point2& b, const Point2& c);

// Returns 1: a, b, c turn left (counter-clockwise); -1: they turn right; 0: they lie on one line. Exact for finite
// coordinates of any size; those more than 2^400 times smaller than the largest of the six count as 0.
//
// The filter is Shewchuk's: the computed determinant is within (3 + 16u)u times the sum of the magnitudes of its two
// products of the exact one, u = 2^-53, where nothing underflows. NaN and infinity, after an overflow, do not pass it.
inline constexpr double kOrientationError = 0x1.8000000000004p-52;
inline constexpr double kLeastTurn = 0x1p-900;  // smaller determinants may have underflowed

inline int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double determinant = left - right;
  if (std::abs(determinant) > kOrientationError * (std::abs(left) + std::abs(right)) + kLeastTurn) [[likely]] {
    return determinant > 0 ? 1 : -1;
  }
  return exact_orientation(a, b, c);
}

// Returns the sign of the area that an outline winds around: 1 counter-clockwise, -1 clockwise, 0 no area. Exact under
// the same conditions.
int area_sign(std::span<const Point2> outline);

}  // namespace meshgauge::api
