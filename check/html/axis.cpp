#include "check/html/axis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "check/html/svg.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

constexpr double kMagnitudes = 15;   // ratio of largest to smallest from which a linear axis would hide the small ones
constexpr double kNeighbours = 0.8;  // ratio of smallest to largest from which the axis shows their neighbourhood
constexpr std::size_t kMostTicks = 7;

// Whether an axis can show the number; the limits leave room for the arithmetic.
bool shown(double x) { return x > 1e-300 && x < 1e300; }

std::vector<AxisTick> linear_ticks(const Axis& axis) {
  std::vector<AxisTick> ticks;
  const double step = svg::round_length((axis.high - axis.low) / 3);  // gives two to six ticks
  const double first = std::ceil(axis.low / step);
  for (double i = first; i * step <= axis.high && ticks.size() < kMostTicks; ++i) {
    ticks.push_back({i * step, to_digits(i * step, 9)});
  }
  return ticks;
}

// Powers of ten, with their 2- and 5-fold if there is room.
std::vector<AxisTick> logarithmic_ticks(const Axis& axis) {
  std::vector<AxisTick> ticks;
  const double first = std::floor(std::log10(axis.low)), last = std::floor(std::log10(axis.high));
  const double step = std::max(1.0, std::ceil((last - first) / static_cast<double>(kMostTicks)));
  for (double i = first; i <= last; i += step) {
    for (const double digit : {1, 2, 5}) {
      const double value = digit * std::pow(10, i);
      if (value < axis.low || value > axis.high || (digit > 1 && last - first > 2)) continue;
      ticks.push_back({value, to_digits(value, 9)});
    }
  }
  return ticks;
}

}  // namespace

double Axis::at(double x) const {
  if (!(x > low)) return 0;
  if (!(x < high)) return 1;
  if (!logarithmic) return (x - low) / (high - low);
  return (std::log(x) - std::log(low)) / (std::log(high) - std::log(low));  // high / low could overflow
}

double Axis::value(double share) const {
  if (!logarithmic) return low + share * (high - low);
  return std::exp((1 - share) * std::log(low) + share * std::log(high));
}

Axis axis_for(std::span<const double> values) {
  std::vector<double> counted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(counted), shown);
  if (counted.empty()) return {};
  const auto [least, most] = std::minmax_element(counted.begin(), counted.end());
  const bool all = counted.size() == values.size();
  if (all && *least > kNeighbours * *most) {
    const double room = std::max(0.8 * (*most - *least), 0.01 * *most);
    return {false, *least - room, *most + room};
  }
  if (*most > kMagnitudes * *least) return {true, *least / 2.5, *most * 2.5};
  return {false, 0, 1.25 * *most};
}

std::vector<AxisTick> ticks(const Axis& axis) {
  return axis.logarithmic ? logarithmic_ticks(axis) : linear_ticks(axis);
}

}  // namespace meshgauge::check
