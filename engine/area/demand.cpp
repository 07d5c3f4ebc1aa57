// What AreaSearch still has to narrow.
#include "engine/area/demand.h"

#include <algorithm>
#include <array>

#include "engine/area/area_search.h"
#include "engine/mesh_index.h"
#include "engine/narrowing_time.h"

namespace meshgauge {
namespace {

bool is_decided(const AreaOptions::Beyond& beyond, const AreaInterval& share) {
  return beyond.max_share && (share.upper <= *beyond.max_share || share.lower > *beyond.max_share);
}

}  // namespace

// The width that is narrow enough for the interval of a length with this value.
double AreaSearch::tolerance_of(double length) const {
  return asked_.length_tolerance * std::max(length, AreaOptions::kLeastLength * in_.most);
}

double AreaSearch::tolerance_of_share(std::size_t k) const {
  return asked_.beyond[k].max_share ? std::min(asked_.share_tolerance, AreaOptions::kGateTolerance)
                                    : asked_.share_tolerance;
}

// Whether a share needs no more work.
bool AreaSearch::is_narrow(std::size_t k) const {
  const AreaInterval& share = known_.beyond[k];
  const double width = share.upper - share.lower;
  if (width <= tolerance_of_share(k)) return true;
  return is_decided(asked_.beyond[k], share) && (!is_narrowing_ || width <= kNarrowRelative * share.upper);
}

Demand AreaSearch::demand() const {
  Demand demand;
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    if (!is_narrow(k)) demand.probes.push_back({limits_[k].down, limits_[k].up, 1 / tolerance_of_share(k)});
  }
  for (const AreaInterval& q : known_.quantiles) demand_quantile(q, demand);
  if (known_.mean) {
    const double tolerance = tolerance_of(known_.mean->upper);
    if (known_.mean->upper - known_.mean->lower > tolerance) demand.mean = 1 / tolerance;
  }
  if (known_.rms) {
    const auto& [lower, upper] = *known_.rms;
    const double tolerance = tolerance_of(upper);
    if (upper - lower > tolerance) demand.square = 1 / (tolerance * (upper + lower));
  }
  return demand;
}

// The widths of the shares at the ends and in the middle of the interval, scaled so that they add up to its width in
// tolerances.
void AreaSearch::demand_quantile(const AreaInterval& known, Demand& demand) const {
  const double width = known.upper - known.lower, tolerance = tolerance_of(known.upper);
  if (width <= tolerance) return;
  const std::array at{known.lower, known.lower + width / 2, known.upper};
  double sum = 0;
  each_unless(stop_, open_.size(), [&](std::size_t i) {
    const Part& part = open_[i];
    for (const double t : at) {
      sum += part.weight * (share_beyond(part.enclosure.high, t) - share_beyond(part.enclosure.low, t));
    }
  });
  const double scale = sum > 0 ? width / tolerance * area_.weight / sum : 1;
  for (const double t : at) demand.probes.push_back({t, t, scale});
}

}  // namespace meshgauge
