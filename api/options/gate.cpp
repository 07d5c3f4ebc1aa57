#include "api/options/gate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "api/base/text.h"
#include "api/options/asked_units.h"
#include "api/options/draft.h"
#include "api/options/table.h"
#include "api/options/write_options.h"

namespace meshgauge::api {
namespace {

using Asked = ComparisonOptions;

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
  const Reading::Member members[] = {draft.reading.limit_into("distance", limit.distance),
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
  if (!value.is_array() || value.size() != 2)
    return draft.reading.refuse(
        at, "must be two limits, inside and outside, as [-0.05 mm, 0.1 mm], not " + draft.reading.shown(value));
  const auto inside = draft.reading.limit(value[0], at + "/0", Reading::Sign::minus);
  const auto outside = draft.reading.limit(value[1], at + "/1", Reading::Sign::plus);
  draft.options.zone = SideOptions::Limits{std::abs(inside.value_or(0)), outside.value_or(0)};
  draft.sides_at = at;
}

void read_uncertainty(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.uncertainty_at = at;
  draft.options.uncertainty = draft.reading.limit(value, at).value_or(0);
}

void read_narrow(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.narrow = draft.reading.boolean(value, at);
}

constexpr LimitOption kLimits[] = {
    {{.key = "max_distance",
      .kind = OptionKind::limit,
      .surfaces = kEverywhere,
      .is_limit = true,
      .help = "The largest distance that passes, as a length or as a share ('0.5 %') of the diagonal of {b}",
      .example = "0.05 mm",
      .read = read_max_distance,
      .lengths = [](Asked& o) { return o.max_distance ? OptionLengths{&*o.max_distance} : OptionLengths{}; }},
     [](const Asked& o) { return number_or_null(o.max_distance); }},
    {{.key = "max_share_beyond",
      .surfaces = kEverywhere,
      .is_limit = true,
      .help = "The largest share of the area that may be farther than a distance",
      .example = "{distance: 0.05 mm, share: 1 %}",
      .read = read_max_share_beyond,
      .lengths =
          [](Asked& o) { return o.max_share_beyond ? OptionLengths{&o.max_share_beyond->distance} : OptionLengths{}; }},
     [](const Asked& o) {
       const auto& limit = o.max_share_beyond;
       return limit ? Json{{"distance", limit->distance}, {"share", limit->share}} : Json(nullptr);
     }},
    {{.key = "zone",
      .surfaces = kEverywhere,
      .is_limit = true,
      .help = "How far {a} may be inside and outside of {b}, which must be closed",
      .example = "[-0.05 mm, 0.1 mm]",
      .read = read_zone,
      .lengths =
          [](Asked& o) {
            return o.zone ? OptionLengths{&o.zone->inside, &o.zone->outside} : OptionLengths{};
          }},
     [](const Asked& o) {
       return o.zone ? Json{0 - o.zone->inside, o.zone->outside} : Json(nullptr);
     }},
    {{.key = "uncertainty",
      .kind = OptionKind::limit,
      .surfaces = kEverywhere,
      .help = "The uncertainty of the distances, by more than which they pass and fail (docs/metrology.md)",
      .usual = "0",
      .example = "0.01 mm",
      .read = read_uncertainty,
      .lengths = length_at<&Asked::uncertainty>},
     [](const Asked& o) { return o.uncertainty != 0 ? Json(o.uncertainty) : Json(nullptr); }},
    {{.key = "narrow",
      .kind = OptionKind::toggle,
      .surfaces = kEverywhere,
      .help = "Once the verdict is known, measure on for a while, to say by how much it passes or fails",
      .usual = "true",
      .read = read_narrow},
     [](const Asked&) { return Json(nullptr); }}};

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
    draft.reading.refuse(draft.limits_at, "needs " + listed(limit_names(), " or "));
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
  if (first_length(draft.options).empty()) units.limit.reset();  // a 0 that asks for nothing had a unit
}

}  // namespace

std::optional<LengthUnit> read_unit(const JsonValue& value, const std::string& at, Reading& reading) {
  const auto unit = value.is_string() ? parse_unit(value.get_ref<const std::string&>()) : std::nullopt;
  if (!unit) reading.refuse(at, "must be a unit of length (" + unit_names() + "), not " + reading.shown(value));
  return unit;
}

void read_gate(const JsonValue& value, const std::string& at, Draft& draft) {
  if (!draft.limits_at.empty())
    return draft.reading.refuse(
        at, "stands beside " + draft.reading.surface.name(draft.limits_at) + ": write all limits in one place");
  draft.in_gate = true;
  draft.limits_at = at;
  std::vector<Reading::Member> members;
  for (const LimitOption& one : kLimits) members.push_back(member(one.key, one.read, draft));
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

std::span<const LimitOption> limit_options() { return kLimits; }

std::vector<std::string> limit_names() {
  std::vector<std::string> names;
  for (const LimitOption& one : kLimits) {
    if (one.is_limit) names.emplace_back(one.key);
  }
  return names;
}

bool is_about_limits(std::string_view option) {
  return std::ranges::find(kLimits, option, &LimitOption::key) != std::end(kLimits);
}

bool has_limit(const ComparisonOptions& options) {
  return std::ranges::any_of(kLimits,
                             [&](const LimitOption& one) { return one.is_limit && !one.write(options).is_null(); });
}

bool uncertainty_fits(ComparisonOptions options) {
  for (const Option* option : all_options()) {
    if (!option->is_limit) continue;
    for (const double* limit : option->lengths(options)) {
      if (!(options.uncertainty <= *limit)) return false;
    }
  }
  return true;
}

std::string_view first_length(ComparisonOptions options) {
  std::string_view zero;
  for (const Option* option : all_options()) {
    if (!option->lengths) continue;
    for (const double* length : option->lengths(options)) {
      if (*length != 0) return option->key;
      if (zero.empty()) zero = option->key;
    }
  }
  return zero;
}

void resolve_shares(ComparisonOptions& options, double diagonal) {
  if (!std::exchange(options.units.limit_of_diagonal, false)) return;
  options.units.limit_of_b = true;
  const auto resolve = [diagonal](double& share) {  // none of an unknown diagonal is none, too
    if (share != 0) share = std::min(share * diagonal, std::numeric_limits<double>::max());
  };
  for (const Option* option : all_options()) {
    if (!option->lengths || option->kind == OptionKind::length) continue;
    for (double* share : option->lengths(options)) resolve(*share);
  }
}

Options engine_options(const ComparisonOptions& options) {
  Options engine = options;
  if (options.zone) {
    if (!engine.sides) engine.sides.emplace();
    engine.sides->limits = options.zone;
  }
  if (!options.max_share_beyond) return engine;
  if (!engine.areas) engine.areas.emplace();
  const auto& [distance, share] = *options.max_share_beyond;
  const LimitEnds ends = options.ends(distance);
  if (ends.are_apart()) engine.areas->beyond.push_back({ends.pass, share});
  engine.areas->beyond.push_back({ends.fail, share});
  return engine;
}

std::optional<double> limit_of_region(const ComparisonOptions& options, std::size_t region) {
  const auto own = region < options.regions.size() ? options.regions[region].max_distance : std::nullopt;
  return own ? own : options.max_distance;
}

}  // namespace meshgauge::api
