#include "api/options/gate.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace meshgauge::api {

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

std::optional<double> limit_of_region(const ComparisonOptions& options, std::size_t region) {
  const auto own = region < options.regions.size() ? options.regions[region].max_distance : std::nullopt;
  return own ? own : options.max_distance;
}

}  // namespace meshgauge::api
