// What the outline of a face is: convex, crossing itself. Closed: the last corner is followed by the first.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "api/formats/orientation.h"

namespace meshgauge::api {

// Work left for splitting the faces of one file, in steps of a few nanoseconds.
class StepBudget {
 public:
  explicit StepBudget(std::size_t steps) : left_(steps) {}

  // false: fewer steps than that are left, and from now on none.
  bool spend(std::size_t steps) {
    const bool enough = steps <= left_;
    left_ = enough ? left_ - steps : 0;
    return enough;
  }
  std::size_t left() const { return left_; }

 private:
  std::size_t left_;
};
inline constexpr std::size_t kOrientationSteps = 8;  // of a few orientation tests

struct Turns {
  bool convex = false;    // bounds a convex region once, either way round; corners may lie on edges and repeat
  bool has_both = false;  // some corners turn left and some right
};

Turns turns_of(std::span<const Point2> outline);

// Whether two edges cross at an inner point of both. Outlines that only touch themselves do not cross. The work is
// n log n for outlines that do not run back and forth many times; false, too, once the budget is spent.
bool crosses_itself(std::span<const Point2> outline, StepBudget& budget);

}  // namespace meshgauge::api
