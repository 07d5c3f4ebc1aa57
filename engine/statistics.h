// Statistics of the distance to the other mesh over a whole surface: mean, quantiles and histogram, from sampled
// points. They are estimates with standard errors (docs/statistics.md) and never part of the certified interval.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "engine/control.h"

namespace meshgauge {

// The number of points that are drawn independently from one stratum, a patch of the surface. Fewer points from smaller
// patches would vary less, but would show too little of how much they vary: with two, the 99 % quantile of 2000 samples
// was off by up to twelve standard errors.
inline constexpr std::size_t kPointsAStratum = 10;

struct Sampling {
  std::size_t samples = 100'000;  // points in each direction; rounded up to full strata
  std::uint64_t seed = 1;         // another seed gives other points
};

// The standard error covers sampling alone: the estimated standard deviation of `value` over the seeds.
struct Estimate {
  double value = 0;
  double standard_error = 0;
};

// The measure that the sampled points are uniform in. `length`: all triangles are degenerate, and the points lie on the
// segments that they span. `points`: the segments have no length either.
enum class Weight { area, length, points };

// Statistics of the distance from the points of one mesh to the other mesh, in the meshes' unit.
struct Distribution {
  static constexpr std::size_t kBins = 32;

  Weight weight = Weight::area;
  std::size_t samples = 0;  // number of sampled points; of a cloud all of its points, and no estimate has an error
  Estimate mean;
  Estimate rms;                           // root of the mean square
  Estimate p50, p95, p99;                 // quantiles: 50, 95 and 99 percent of the surface are at most that far
  double max_seen = 0;                    // largest sampled distance; never above the certified upper bound
  std::array<Estimate, kBins> histogram;  // shares of the surface; equal bins from 0 to max_seen
};

// `complete`, or the reason why a direction is missing.
enum class StatisticsStatus { complete, timeout, cancelled, memory };

struct Statistics {
  Sampling sampling;
  std::optional<Distribution> a_to_b;  // nullopt: not asked for, or see `status`
  std::optional<Distribution> b_to_a;
  StatisticsStatus status = StatisticsStatus::complete;
};

// Returns the estimates from sampled distances: kPointsAStratum consecutive values from each stratum, and all strata
// have the same weight. Does not set Distribution::weight. Precondition: there is at least one stratum.
Distribution summarize(std::span<const double> values);

// The same of distances that are all there are, in any number but 0: no value has an error.
Distribution summarize_all(std::span<const double> values);

}  // namespace meshgauge
