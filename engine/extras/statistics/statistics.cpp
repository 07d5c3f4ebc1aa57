#include "engine/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace meshgauge {
namespace {

// The error of a quantile is derived from the values this many standard errors of the rank above and below it.
constexpr double kErrorsAside = 2;

// One stratum's share in the variance of a count of values: `count` of its values are counted.
double variance_of_count(std::size_t count) {
  return static_cast<double>(count * (kPointsAStratum - count)) / static_cast<double>(kPointsAStratum - 1);
}

// Everything from n = kL values x, k independent ones in each of L strata (docs/statistics.md):
//   mean = sum x / n,   variance of the mean = k / (k - 1) * sum (x - mean of its stratum)^2 / n^2, without bias.
// Values that are all there are form one stratum, without an error.
class Summary {
 public:
  Summary(std::span<const double> values, bool all)
      : values_(values),
        all_(all),
        stratum_(all ? values.size() : kPointsAStratum),
        n_(static_cast<double>(values.size())),
        sorted_(values.begin(), values.end()) {
    std::sort(sorted_.begin(), sorted_.end());
  }

  double largest() const { return sorted_.back(); }

  template <class Value>
  Estimate mean(const Value& value) const {
    double sum = 0, squares = 0;
    in_strata([&](std::span<const double> stratum) {
      const double first = value(stratum[0]);  // subtracted, so that equal values deviate by exactly 0
      double here = 0;
      for (const double x : stratum) here += value(x) - first;
      const auto count = static_cast<double>(stratum.size());
      for (const double x : stratum) squares += square(value(x) - first - here / count);
      sum += here + first * count;
    });
    if (all_) return {sum / n_, 0};
    return {sum / n_, std::sqrt(squares * kPointsAStratum / (kPointsAStratum - 1)) / n_};
  }

  // By the delta method: an error e of the mean square is an error e / (2 rms) of its root. Values are divided by the
  // largest one, because its square may underflow.
  Estimate rms() const {
    if (largest() == 0) return {};
    const Estimate squares = mean([this](double x) { return square(x / largest()); });
    const double root = std::sqrt(squares.value);
    return {root * largest(), squares.standard_error / (2 * root) * largest()};
  }

  // By Woodruff's interval: the number of values of at most `value` has a standard error, and the values at the ranks
  // that much higher and lower show how far the quantile errs. The variance starts at 1, for the gap between two
  // values.
  Estimate quantile(double share) const {
    const double value = at_rank(share * n_);
    if (all_) return {value, 0};
    double variance = 1;
    in_strata([&](std::span<const double> stratum) {
      const auto count = std::count_if(stratum.begin(), stratum.end(), [&](double x) { return x <= value; });
      variance += variance_of_count(static_cast<std::size_t>(count));
    });
    const double aside = kErrorsAside * std::sqrt(variance);
    return {value, (at_rank(share * n_ + aside) - at_rank(share * n_ - aside)) / (2 * kErrorsAside)};
  }

  // The shares of equal bins from 0 to the largest value.
  std::array<Estimate, Distribution::kBins> histogram() const {
    std::array<double, Distribution::kBins> counts{}, variances{};
    in_strata([&](std::span<const double> stratum) {
      std::array<std::size_t, Distribution::kBins> here{};
      for (const double x : stratum) ++here[bin_of(x)];
      for (std::size_t b = 0; b < here.size(); ++b) {
        counts[b] += static_cast<double>(here[b]);
        if (!all_) variances[b] += variance_of_count(here[b]);
      }
    });
    std::array<Estimate, Distribution::kBins> shares;
    for (std::size_t b = 0; b < shares.size(); ++b)
      shares[b] = {counts[b] / n_, all_ ? 0 : std::sqrt(variances[b] + 1) / n_};
    return shares;
  }

 private:
  static double square(double x) { return x * x; }

  template <class Each>
  void in_strata(const Each& each) const {
    for (std::size_t i = 0; i < values_.size(); i += stratum_) each(values_.subspan(i, stratum_));
  }

  double at_rank(double rank) const {  // `rank` counts from 1
    return sorted_[static_cast<std::size_t>(std::clamp(std::ceil(rank), 1.0, n_)) - 1];
  }

  std::size_t bin_of(double x) const {
    if (largest() == 0) return 0;
    constexpr std::size_t kLast = Distribution::kBins - 1;
    return std::min(static_cast<std::size_t>(x / largest() * Distribution::kBins), kLast);
  }

  std::span<const double> values_;
  bool all_;
  std::size_t stratum_;
  double n_;
  std::vector<double> sorted_;
};

Distribution distribution_of(std::span<const double> values, bool all) {
  const Summary summary(values, all);
  Distribution found;
  found.samples = values.size();
  found.mean = summary.mean([](double x) { return x; });
  found.rms = summary.rms();
  found.p50 = summary.quantile(0.50);
  found.p95 = summary.quantile(0.95);
  found.p99 = summary.quantile(0.99);
  found.max_seen = summary.largest();
  found.histogram = summary.histogram();
  // Rounding of the sum could put the mean of equal values above them.
  for (Estimate* average : {&found.mean, &found.rms}) average->value = std::min(average->value, found.max_seen);
  return found;
}

}  // namespace

Distribution summarize(std::span<const double> values) {
  assert(!values.empty() && values.size() % kPointsAStratum == 0);
  return distribution_of(values, false);
}

Distribution summarize_all(std::span<const double> values) {
  assert(!values.empty());
  return distribution_of(values, true);
}

}  // namespace meshgauge
