#include "engine/mesh/frame.h"

#include <algorithm>
#include <cmath>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

// Up to this many steps from 0 the centre of an axis is a multiple of the step; beyond, it is the middle itself.
constexpr double kMostSteps = 0x1p40;

// A power of two from 0.29 to 0.585 times the width; 0 for a single point. The limits between two steps are not at
// powers of two: many meshes are scaled to a size of 1, and their frame should not depend on a rounding of it.
double step_of(double widest) {
  if (widest == 0) return 0;
  int exponent = 0;
  std::frexp(widest * 1.17, &exponent);  // m * 2^exponent with m in [1/2, 1)
  return std::ldexp(1.0, exponent - 2);
}

// A multiple of `step` near `middle`. The limit between two of them is not halfway, where round numbers are.
double coarse_middle(double middle, double step) {
  if (!(std::abs(middle) < step * kMostSteps)) return middle;
  return std::copysign(step * std::floor(std::abs(middle) / step + 0.44), middle);
}

// Let w be the width of the widest axis. With m = min(|low|,|high|) >= w and one sign (say positive), every x of
// [low,high] has m <= x <= m + w, and the computed middle is off by less than 2^-12 w, so that
//   |c - middle| <= 0.56 step + 2^-12 w < 0.33 w.
// On an axis of width v <= w:
//   c <= low + v/2 + 0.33 w <= 1.83 low <= 2x     and     2c >= low + high - 0.66 w >= high + 0.34 w >= x,
// Sterbenz' condition, also for an x that lies beside the box by rounding. Where the step is too small, c is the middle
// itself, and both hold all the more.
double centre_of(double low, double high, double widest, double step) {
  const bool one_sign = (low > 0) == (high > 0) && low != 0 && high != 0;
  if (!one_sign || std::min(std::abs(low), std::abs(high)) < widest) return 0;
  return coarse_middle(std::clamp(low / 2 + high / 2, low, high), step);
}

}  // namespace

// The largest offset is at least w/2, that of the widest axis. It is at most v/2 + 0.33 w < w on an axis that is moved,
// and below 2w on one that is not, since its m is below w or 0 lies within.
Frame::Frame(const Box& box) {
  const double widest = (box.high - box.low).maxCoeff();
  const double step = step_of(widest);
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    centre_[k] = centre_of(box.low[k], box.high[k], widest, step);
    largest = std::max({largest, std::abs(box.low[k] - centre_[k]), std::abs(box.high[k] - centre_[k])});
  }
  if (largest == 0) return;
  std::frexp(largest, &exponent_);  // largest = m * 2^exponent with m in [1/2, 1)
  factor_ = std::ldexp(1.0, std::clamp(-exponent_, -1000, 1000));
  factor_rest_ = std::ldexp(1.0, -exponent_ - std::clamp(-exponent_, -1000, 1000));
}

Vec3 Frame::from_frame(const Vec3& p) const {
  Vec3 q;
  for (int k = 0; k < 3; ++k) q[k] = std::ldexp(p[k], exponent_) + centre_[k];
  return q;
}

double Frame::rounding_of_points() const {
  const double subnormal = length_to_frame(2 * std::numeric_limits<double>::denorm_min());
  return rounding::kUnit * 2 * (length_to_frame(centre_.cwiseAbs().maxCoeff()) + 1) + subnormal;
}

double Frame::length_to_frame(double length) const { return std::ldexp(length, -exponent_); }

}  // namespace meshgauge
