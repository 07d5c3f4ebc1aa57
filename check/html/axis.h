// An axis of a diagram: positions of numbers, and its ticks.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace meshgauge::check {

// Linear, or logarithmic for numbers of several magnitudes. low < high, both finite; low > 0 on a logarithmic axis,
// where smaller numbers lie at its beginning.
struct Axis {
  bool logarithmic = false;
  double low = 0;
  double high = 1;

  double at(double x) const;         // from 0 at the beginning to 1 at the end, clamped; NaN is 0
  double value(double share) const;  // inverse of at()
};

// Returns an axis that shows all of `values` with room on both sides. Ignores values that are not positive and
// finite. Values close together get an axis around them, values of several magnitudes a logarithmic one.
Axis axis_for(std::span<const double> values);

struct AxisTick {
  double value = 0;
  std::string label;
};

// Returns round numbers on the axis, at most nine.
std::vector<AxisTick> ticks(const Axis& axis);

}  // namespace meshgauge::check
