// Tests the outline of a face: convex, crossing itself. Outlines are closed: the first corner follows the last.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "api/formats/orientation.h"

namespace meshgauge::api {

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
