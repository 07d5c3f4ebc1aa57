#include "engine/frame.h"

#include <algorithm>
#include <cmath>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

// With m = min(|low|,|high|) >= high - low =: w and one sign, every x of [low,high] and the centre c satisfy
// c <= m + w/2 + rounding <= 2m <= 2|x| and |x| <= m + w <= 2m <= 2|c|: Sterbenz' condition.
double centre_of(double low, double high) {
  const bool one_sign = (low > 0) == (high > 0) && low != 0 && high != 0;
  if (!one_sign || std::min(std::abs(low), std::abs(high)) < high - low) return 0;
  return std::clamp(low / 2 + high / 2, low, high);
}

}  // namespace

Frame::Frame(const Box& box) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    centre_[k] = centre_of(box.low[k], box.high[k]);
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
