// What AreaSearch still has to narrow.
#include "engine/extras/area/demand.h"

#include <algorithm>
#include <array>

#include "engine/extras/area/area_search.h"
#include "engine/mesh/mesh_index.h"
#include "engine/search/narrowing_time.h"

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

// The values from which a lower function of the part is as good as a higher one.
double AreaSearch::most_needed(const Part& part) const {
  // From the nearest corner down: the lower, the less of B matters.
  constexpr double kAbove = 1.125, kNear = 1.03;
  if (!are_shares_alone()) return in_.most;
  const auto& [a, b, c] = part.corners;
  const double nearest = std::min({a.distance, b.distance, c.distance});
  double limit = 0;
  for (const Limit& l : limits_) limit = std::max(limit, l.up);
  return nearest > kNear * limit ? std::min(kAbove * limit, (nearest + limit) / 2) : in_.most;
}

// Whether a part whose corners are not measured should be: its functions are far apart.
bool AreaSearch::is_worth_measuring(const Part& part) {
  constexpr double kLoose = 0.05;
  if (!part.is_rough || !part.has_low) return false;
  double gap = 0;
  for (std::size_t i = 0; i < 3; ++i) gap += part.enclosure.high[i] - part.enclosure.low[i];
  return gap > 3 * kLoose * most(part.enclosure.high);
}

// Whether the part lies under several triangles of B, none of which bounds it well, and is not beyond all limits.
bool AreaSearch::is_worth_cells(const Part& part) const {
  const auto& [a, b, c] = part.corners;
  if (part.is_cell || part.has_failed || (a.slot == b.slot && a.slot == c.slot)) return false;
  constexpr double kLoose = 1.1;
  const Linear& high = part.enclosure.high;
  if (high[0] + high[1] + high[2] <= kLoose * (a.distance + b.distance + c.distance)) return false;
  const double nearest = std::min({a.distance, b.distance, c.distance});
  return std::any_of(limits_.begin(), limits_.end(),
                     [&](const Limit& l) { return nearest <= l.up && most(high) > l.down; });
}

}  // namespace meshgauge
