#include "engine/extras/area/totals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

double root_up(double x) { return std::nextafter(std::sqrt(x), std::numeric_limits<double>::infinity()); }
double root_down(double x) { return std::max(std::nextafter(std::sqrt(x), 0.0), 0.0); }

}  // namespace

// With areas a = w + e, 0 <= e, sum e <= error, and values x in [0, most]: sum a x / sum a is largest when all of the
// error has the value `most`, and then at most (sum w x + error * most) / sum w; it is at least
// sum w x / (sum w + error). Cells (part.h) add cell_error * most to the former sum and take it from the latter.
AreaInterval TotalArea::average(double low, double high, double most) const {
  if (none()) return {0, most};
  const double off = 2 * rounding::sum_error(terms) + rounding::kMeanSlack;
  const double cells = cell_error * most * (1 + 0x1p-20);  // the sum of at most 2^32 errors
  const double upper = (high + cells + error * most) / weight * (1 + off);
  const double lower = (low * (1 - off) - cells) / (weight + error) * (1 - off);
  return {std::clamp(lower, 0.0, most), std::clamp(upper, 0.0, most)};
}

AreaInterval TotalArea::share(const ShareSum& sum) const {
  if (sum.all_zero) return {0, 0};
  if (sum.all_one) return {1, 1};
  const AreaInterval rounded = average(sum.low, sum.high, 1);
  return {std::max(rounded.lower - rounding::kShareSlack, 0.0), std::min(rounded.upper + rounding::kShareSlack, 1.0)};
}

AreaInterval TotalArea::mean(const MeanSum& sum, double most) const { return average(sum.low, sum.high, most); }

AreaInterval TotalArea::rms(const MeanSum& sum, double most) const {
  const AreaInterval squares = average(sum.square_low, sum.square_high, rounding::add_up(most * most, 0));
  return {std::min(root_down(squares.lower), most), std::min(root_up(squares.upper), most)};
}

}  // namespace meshgauge
