#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "api/options/draft.h"
#include "api/options/gate.h"
#include "api/options/unit_plan.h"

namespace meshgauge::api {
namespace {

constexpr std::pair<std::string_view, OptionReader> kLimits[] = {{"max_distance", read_max_distance},
                                                                 {"max_share_beyond", read_max_share_beyond},
                                                                 {"zone", read_zone},
                                                                 {"uncertainty", read_uncertainty},
                                                                 {"narrow", read_narrow}};

void read_limit_unit(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.declared_words = draft.reading.surface.name(at) + " is " + draft.reading.shown(value);
  if (value == kUnitOfB) {
    draft.unit_of_b = true;
  } else if (value == kUnitOfDiagonal) {
    draft.declared = {std::nullopt, true};
  } else if (const auto unit = read_unit(value, at, draft.reading)) {
    draft.declared = {unit, false};
  }
}

void check_limits(Draft& draft) {
  const ComparisonOptions& options = draft.options;
  if (!draft.limits_at.empty() && !has_limit(options) && !draft.reading.surface.by_hand)
    draft.reading.refuse(draft.limits_at, "needs max_distance, max_share_beyond or zone");
  const bool any = std::ranges::any_of(options.regions, [](const Region& r) { return r.max_distance.has_value(); });
  if (!options.max_distance &&
      (any || (draft.reading.surface.by_hand && has_limit(options) && !options.regions.empty())))
    draft.reading.refuse("/regions", "needs max_distance, the limit of what is in no region");
  if (!uncertainty_fits(options))
    draft.reading.refuse(draft.uncertainty_at,
                         "must not be above the distance that may not be exceeded: nothing could pass");
}

void set_unit(Draft& draft) {
  AskedUnits& units = draft.options.units;
  const auto declared = draft.unit_of_b ? std::optional(Reading::LimitUnit{}) : draft.declared;
  const Reading::LimitUnit found = draft.reading.unit_of_limits(declared, draft.declared_words);
  units.limit = found.unit;
  units.limit_of_diagonal = found.of_diagonal;
  units.limit_of_b = draft.unit_of_b;
}

}  // namespace

void read_max_distance(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.options.max_distance = draft.reading.limit(value, at);
}

void read_max_share_beyond(const JsonValue& value, const std::string& at, Draft& draft) {
  constexpr const char* kExample = "{distance: 0.05 mm, share: 1 %}";
  if (!value.is_object())
    return draft.reading.refuse(at, "must be " + std::string(draft.reading.surface.object) +
                                        " of distance and share, as " + kExample + ", not " +
                                        draft.reading.shown(value));
  ShareLimit& limit = draft.options.max_share_beyond.emplace();
  const Reading::Member members[] = {
      {"distance", [&](const JsonValue& v,
                       const std::string& place) { limit.distance = draft.reading.limit(v, place).value_or(0); }},
      {"share", [&](const JsonValue& v, const std::string& place) {
         limit.share = draft.reading.share(v, "the area", place).value_or(0);
       }}};
  draft.reading.members(value, members, at);
  for (const Reading::Member& one : members) {
    if (value.size() < std::size(members) && !value.contains(one.key))
      draft.reading.refuse(at, "has no " + std::string(one.key) + ": write " + kExample);
  }
}

// [-inside, outside]
void read_zone(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.zone_at = at;
  if (!value.is_array() || value.size() != 2)
    return draft.reading.refuse(
        at, "must be two limits, inside and outside, as [-0.05 mm, 0.1 mm], not " + draft.reading.shown(value));
  const auto inside = draft.reading.limit(value[0], at + "/0", Reading::Sign::minus);
  const auto outside = draft.reading.limit(value[1], at + "/1", Reading::Sign::plus);
  draft.options.zone = SideOptions::Zone{std::abs(inside.value_or(0)), outside.value_or(0)};
}

void read_uncertainty(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.uncertainty_at = at;
  draft.options.uncertainty = draft.reading.limit(value, at).value_or(0);
}

void read_narrow(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.narrow = draft.reading.boolean(value, at);
}

std::optional<LengthUnit> read_unit(const JsonValue& value, const std::string& at, Reading& reading) {
  const auto unit = value.is_string() ? parse_unit(value.get_ref<const std::string&>()) : std::nullopt;
  if (!unit)
    reading.refuse(at, "must be a unit of length (" + std::string(kUnitNames) + "), not " + reading.shown(value));
  return unit;
}

void read_gate(const JsonValue& value, const std::string& at, Draft& draft) {
  if (!draft.limits_at.empty())
    return draft.reading.refuse(
        at, "stands beside " + draft.reading.surface.name(draft.limits_at) + ": write all limits in one place");
  draft.in_gate = true;
  draft.limits_at = at;
  std::vector<Reading::Member> members;
  for (const auto& [key, read] : kLimits) members.push_back(member(key, read, draft));
  members.push_back(member("units", read_limit_unit, draft));
  draft.reading.members(value, members, at);
}

void complete_limits(Draft& draft) {
  if (draft.reading.mistakes.empty()) set_unit(draft);
  if (draft.reading.mistakes.empty()) check_limits(draft);
  const bool limited = has_limit(draft.options);
  draft.options.narrow = limited && draft.narrow.value_or(true);
  if (limited && !draft.tolerance_given && !draft.in_gate)
    draft.options.tolerance = draft.options.max_distance ? kToleranceOfGate : kToleranceOfArea;
}

}  // namespace meshgauge::api
