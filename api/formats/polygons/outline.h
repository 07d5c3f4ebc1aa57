// Tests the outline of a face: on which side of a line a point lies, decided exactly; whether it is convex or crosses
// itself. Outlines are closed: the first corner follows the last.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

namespace meshgauge::api {

struct Point2 {
  double x = 0;
  double y = 0;

  bool operator==(const Point2&) const = default;
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

// Budget for splitting the faces of one file, in steps of a few nanoseconds.
class StepBudget {
 public:
  explicit StepBudget(std::size_t steps) : left_(steps) {}

  // Takes steps from the budget. false: fewer were left; the budget is then 0.
  bool spend(std::size_t steps) {
    const bool enough = steps <= left_;
    left_ = enough ? left_ - steps : 0;
    return enough;
  }
  std::size_t left() const { return left_; }

 private:
  std::size_t left_;
};
inline constexpr std::size_t kOrientationSteps = 8;  // cost of a few orientation tests

struct Turns {
  bool convex = false;    // winds once around a convex region, in either direction; corners may lie on edges or repeat
  bool has_both = false;  // some corners turn left and some right
};

Turns turns_of(std::span<const Point2> outline);

// Returns true when two edges cross at an inner point of both; false also once the budget is spent. An outline that
// only touches itself does not cross. Takes n log n steps unless the outline runs back and forth many times.
bool crosses_itself(std::span<const Point2> outline, StepBudget& budget);

}  // namespace meshgauge::api
