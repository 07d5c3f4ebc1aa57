// Where a number lies on the axis of a picture, and the numbers that are written along it.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace meshgauge::check {

// Linear, or logarithmic where the numbers are of several magnitudes. low < high, both finite; on a logarithmic axis
// low > 0, and what is below it lies at its beginning.
struct Axis {
  bool logarithmic = false;
  double low = 0;
  double high = 1;

  double at(double x) const;         // 0 at the beginning, 1 at the end, never beyond; NaN is 0
  double value(double share) const;  // the inverse
};

// An axis that shows all of `values` with room on both sides. Those that are not positive and finite do not count.
// Values that are close together get an axis of their own neighbourhood, values of several magnitudes a logarithmic
// one.
Axis axis_for(std::span<const double> values);

struct AxisTick {
  double value = 0;
  std::string label;
};

// Round numbers on the axis, at most nine.
std::vector<AxisTick> ticks(const Axis& axis);

}  // namespace meshgauge::check
