#include "check/manifest/quantities.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "api/formats/text.h"
#include "api/gate.h"
#include "api/json_filter.h"
#include "api/refused.h"
#include "api/request.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

Error no_unit(std::string_view text) {
  return refused("must be a unit of length (" + std::string(api::kUnitNames) + "), not " + api::shown_text(text));
}

bool is_bare_zero(const Limit& limit) { return limit.max_distance == 0.0 && !limit.unit; }

Result<Limit> limit_of(const Result<api::Length>& length) {
  if (!length) return length.error();
  Limit limit;
  (length->is_share ? limit.max_diagonal_share : limit.max_distance) = length->number;
  limit.unit = length->unit;
  return limit;
}

}  // namespace

Result<Limit> parse_length(std::string_view text) { return limit_of(api::parse_length(text, false)); }

Result<Limit> parse_limit(std::string_view text) { return limit_of(api::parse_length(text, true)); }

Result<AreaLimit> parse_area_limit(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos)
    return refused("must be a distance, ':' and a share of the area (0.05 mm: 1 %), not " + api::shown_text(text));
  const auto distance = parse_limit(text.substr(0, colon));
  if (!distance) return refused("the distance " + distance.error().message);
  const auto share = api::parse_share(text.substr(colon + 1));
  if (!share) return refused("the share " + share.error().message);
  return AreaLimit{*distance, *share};
}

Result<Limit> parse_zone_end(std::string_view text, bool is_inside) {
  const std::string_view end = trimmed(text);
  const bool is_signed = end.starts_with(is_inside ? '-' : '+');
  auto limit = parse_limit(is_signed ? trimmed(end.substr(1)) : end);
  const bool is_zero = limit && limit->max_distance.value_or(0) + limit->max_diagonal_share.value_or(0) == 0;
  if (limit && is_inside && !is_signed && !is_zero)
    return refused("must be 0 or below it, as -0.05 mm: it is how far inside; not " + api::shown_text(text));
  return limit;
}

ZoneLimit zone_of(Limit inside, Limit outside) {
  for (Limit* end : {&inside, &outside}) {
    const Limit& other = end == &inside ? outside : inside;
    if (!is_bare_zero(*end)) continue;
    end->unit = other.unit;
    if (other.max_diagonal_share) end->max_diagonal_share = *std::exchange(end->max_distance, std::nullopt);
  }
  return {inside, outside};
}

Result<ZoneLimit> parse_zone(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos)
    return refused("must be the limits inside and outside of the baseline (-0.05 mm, 0.1 mm), not " +
                   api::shown_text(text));
  const auto inside = parse_zone_end(text.substr(0, comma), true);
  if (!inside) return refused("the first limit " + inside.error().message);
  const auto outside = parse_zone_end(text.substr(comma + 1), false);
  if (!outside) return refused("the second limit " + outside.error().message);
  return zone_of(*inside, *outside);
}

Result<Done> check_limits(const Gate& gate) {
  const auto kind = [](const Limit& limit) {
    if (limit.max_diagonal_share) return std::string("is a share of the diagonal");
    return limit.unit ? "is in " + std::string(to_string(*limit.unit)) : std::string("has no unit");
  };
  const auto same = [&](const Limit& one, const char* name, const Limit& other, const char* limit) -> Result<Done> {
    if (!one.is_given() || !other.is_given() || is_bare_zero(one) || kind(one) == kind(other)) return Done{};
    return refused(name + kind(one) + ", and " + limit + kind(other) +
                   ": a gate is measured in one unit, write both in the same");
  };
  const Limit none;
  const Limit& beyond = gate.area_limit ? gate.area_limit->distance : none;
  if (auto ok = same(beyond, "max_share_beyond: its distance ", gate.limit, "max_distance "); !ok) return ok;
  if (gate.zone) {
    const Limit& outside = gate.zone->outside;
    if (auto ok = same(gate.zone->inside, "zone: its first limit ", outside, "the second "); !ok) return ok;
    if (auto ok = same(outside, "zone: its second limit ", main_limit(gate), "the other limit "); !ok) return ok;
  }
  if (auto ok = same(gate.uncertainty, "uncertainty ", main_limit(gate), "the limit "); !ok) return ok;
  for (const RegionLimit& one : gate.regions) {
    const std::string name = "the region " + api::shown_text(one.region.name) + ": its limit ";
    if (auto ok = same(one.limit, name.c_str(), gate.limit, "max_distance "); !ok) return ok;
    if (gate.options.direction == Direction::a_to_b && std::holds_alternative<Group>(one.region.shape))
      return refused("the region " + api::shown_text(one.region.name) +
                     " is a group of the baseline: the direction must be symmetric or baseline_to_candidate");
  }
  if (!gate.regions.empty() && !gate.limit.is_given() && (gate.area_limit || gate.zone))
    return refused("regions needs max_distance, the limit of what is in no region");
  const api::ComparisonOptions options = options_of(gate, limits_of(gate, 1));
  if (gate.zone && options.direction == Direction::b_to_a)
    return refused(
        "zone is about the points of the candidate: the direction must be symmetric or candidate_to_baseline");
  return api::check_uncertainty(options, "uncertainty");
}

Result<LengthUnit> parse_unit(std::string_view text) {
  const auto unit = api::parse_unit(trimmed(text));
  if (!unit) return no_unit(text);
  return *unit;
}

}  // namespace meshgauge::check
