#include "api/options/gate.h"

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

namespace meshgauge::api {
Verdict worst(Verdict a, Verdict b) {
  if (a == Verdict::fail || b == Verdict::fail) return Verdict::fail;
  return a == Verdict::pass ? b : a;
}

std::string_view to_string(Verdict verdict) {
  constexpr std::string_view kNames[] = {"pass", "fail", "undecided"};
  return kNames[static_cast<std::size_t>(verdict)];
}

bool uncertainty_fits(const ComparisonOptions& options) {
  const double u = options.uncertainty;
  const auto& area = options.max_share_beyond;
  const auto fits = [u](const Region& region) { return u <= region.max_distance.value_or(u); };
  const auto& zone = options.zone;
  return u <= options.max_distance.value_or(u) && u <= (area ? area->distance : u) &&
         (!zone || (u <= zone->inside && u <= zone->outside)) && std::ranges::all_of(options.regions, fits);
}

void resolve_shares(ComparisonOptions& options, double diagonal) {
  if (!std::exchange(options.units.limit_of_diagonal, false)) return;
  options.units.limit_of_b = true;
  const auto resolve = [diagonal](double& share) {
    share = std::min(share * diagonal, std::numeric_limits<double>::max());
  };
  if (options.max_distance) resolve(*options.max_distance);
  if (options.max_share_beyond) resolve(options.max_share_beyond->distance);
  if (options.zone) resolve(options.zone->inside), resolve(options.zone->outside);
  resolve(options.uncertainty);
  for (Region& region : options.regions) {
    if (region.max_distance) resolve(*region.max_distance);
  }
}

Verdict verdict_within(double lower, double upper, double limit, double uncertainty) {
  if (upper <= less_uncertainty(limit, uncertainty)) return Verdict::pass;
  return lower > plus_uncertainty(limit, uncertainty) ? Verdict::fail : Verdict::undecided;
}

DistanceLimit shown_limit(std::span<const DistanceLimit> limits, double uncertainty) {
  const auto rank = [&](const DistanceLimit& one) {
    const Verdict found = verdict_within(one.lower, one.upper, one.limit, uncertainty);
    const int severity = found == Verdict::fail ? 2 : found == Verdict::undecided ? 1 : 0;
    return std::tuple(severity, one.side.empty(), severity == 0 ? one.limit : -one.limit);
  };
  return *std::ranges::max_element(limits, {}, rank);
}

Options engine_options(const ComparisonOptions& options) {
  Options engine = options;
  if (options.zone) {
    if (!engine.sides) engine.sides.emplace();
    engine.sides->zone = options.zone;
  }
  if (!options.max_share_beyond) return engine;
  if (!engine.areas) engine.areas.emplace();
  const auto& [distance, share] = *options.max_share_beyond;
  if (options.uncertainty > 0) engine.areas->beyond.push_back({less_uncertainty(distance, options.uncertainty), share});
  engine.areas->beyond.push_back({plus_uncertainty(distance, options.uncertainty), share});
  return engine;
}

std::optional<AreaInterval> share_beyond(const Outcome& outcome, const ComparisonOptions& options) {
  if (!options.max_share_beyond) return std::nullopt;
  AreaInterval share;
  const std::size_t asked = options.uncertainty > 0 ? 2 : 1;
  const auto add = [&](const std::optional<AreaBounds>& found) {
    const bool known = found && found->beyond.size() >= asked;
    share.lower = std::max(share.lower, known ? found->beyond.back().lower : 0);
    share.upper = std::max(share.upper, known ? found->beyond[found->beyond.size() - asked].upper : 1);
  };
  const AreaOutcome areas = outcome.areas.value_or(AreaOutcome{});
  if (options.direction != Direction::b_to_a) add(areas.a_to_b);
  if (options.direction != Direction::a_to_b) add(areas.b_to_a);
  return share;
}

std::optional<double> limit_of_region(const ComparisonOptions& options, std::size_t region) {
  const auto own = region < options.regions.size() ? options.regions[region].max_distance : std::nullopt;
  return own ? own : options.max_distance;
}

}  // namespace meshgauge::api
