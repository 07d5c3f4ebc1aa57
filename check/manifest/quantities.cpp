#include "check/manifest/quantities.h"

#include <algorithm>
#include <cmath>
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

struct Quantity {
  double number = 0;
  std::string_view unit;
};

// Splits a decimal number from the text behind it. "inf" and "nan" are not numbers.
std::optional<Quantity> split(std::string_view text) {
  text = trimmed(text);
  const std::size_t digit = text.find_first_not_of("+-.");
  if (digit == std::string_view::npos || !api::is_digit(text[digit])) return std::nullopt;
  Quantity quantity;
  const char* end = text.data() + text.size();
  const char* next = api::parse_number(text.data(), end, quantity.number);
  if (!next) return std::nullopt;
  quantity.unit = trimmed({next, static_cast<std::size_t>(end - next)});
  return quantity;
}

Error no_length(std::string_view text, const char* shapes) {
  const bool comma = text.find(',') != std::string_view::npos;
  return refused(std::string("must be ") + shapes + ", not " + api::shown_text(text) +
                 (comma ? "; write the decimals behind a point" : ""));
}

Error no_unit(std::string_view text) {
  return refused("must be a unit of length (" + std::string(api::kUnitNames) + "), not " + api::shown_text(text));
}

bool is_bare_zero(const Limit& limit) { return limit.max_distance == 0.0 && !limit.unit; }

// Text behind the number must be a unit: "5e-", "0,05" and "0x10" are mistakes, not the numbers that they begin with.
Result<Limit> length_of(const Quantity& quantity, std::string_view text, const char* shapes, bool or_share) {
  Limit limit;
  if (!quantity.unit.empty()) {
    limit.unit = api::parse_unit(quantity.unit);
    const bool word = std::all_of(quantity.unit.begin(), quantity.unit.end(), api::is_letter);
    if (!limit.unit && !word) return no_length(text, shapes);
    if (!limit.unit)
      return refused("must have a unit of length (" + std::string(api::kUnitNames) + ") behind the number" +
                     (or_share ? ", or '%' for a share of the baseline's diagonal" : "") + ", not " +
                     api::shown_text(text));
  }
  if (!api::in_range(quantity.number, api::kMaxDistanceRange, "").ok()) {
    return refused("must be a finite number of at least 0, not " + api::shown_text(text));
  }
  return limit.max_distance = quantity.number, limit;
}

}  // namespace

Result<Limit> parse_length(std::string_view text) {
  constexpr const char* kShapes = "a number (0.05) or a number and a unit (0.05 mm)";
  const auto quantity = split(text);
  return quantity ? length_of(*quantity, text, kShapes, false) : no_length(text, kShapes);
}

Result<Limit> parse_limit(std::string_view text) {
  constexpr const char* kShapes =
      "a number (0.05), a number and a unit (0.05 mm) or a share of the baseline's diagonal (0.5 %)";
  const auto quantity = split(text);
  if (!quantity) return no_length(text, kShapes);
  if (quantity->unit != "%") return length_of(*quantity, text, kShapes, true);
  auto limit = length_of({quantity->number, ""}, text, kShapes, true);
  if (!limit) return limit;
  limit->max_diagonal_share = *std::exchange(limit->max_distance, std::nullopt) / 100;
  return limit;
}

Result<double> parse_share(std::string_view text) {
  const auto quantity = split(text);
  if (!quantity || quantity->unit != "%")
    return refused("must be a share of the area in percent (1 %), not " + api::shown_text(text));
  if (!(quantity->number >= 0 && quantity->number <= 100))
    return refused("must be from 0 % to 100 %, not " + api::shown_text(text));
  return quantity->number / 100;
}

Result<AreaLimit> parse_area_limit(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos)
    return refused("must be a distance, ':' and a share of the area (0.05 mm: 1 %), not " + api::shown_text(text));
  const auto distance = parse_limit(text.substr(0, colon));
  if (!distance) return refused("the distance " + distance.error().message);
  const auto share = parse_share(text.substr(colon + 1));
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

Result<std::chrono::milliseconds> parse_duration(std::string_view text) {
  const auto quantity = split(text);
  const auto factor = [&]() -> std::optional<double> {
    if (!quantity) return std::nullopt;
    if (quantity->unit.empty() || quantity->unit == "s") return 1000;
    if (quantity->unit == "ms") return 1;
    return quantity->unit == "min" ? std::optional<double>(60'000) : std::nullopt;
  }();
  if (!factor)
    return refused("must be a time, as 60 s, 500 ms, 2 min or a number of seconds, not " + api::shown_text(text));
  const double milliseconds = std::nearbyint(quantity->number * *factor);
  if (const auto checked = api::in_range(milliseconds, api::kTimeoutMsRange, ""); !checked) {
    const auto most = static_cast<int>(api::kTimeoutMsRange.high / 1000);
    return refused("must be from 1 ms to " + std::to_string(most) + " s, not " + api::shown_text(text));
  }
  return std::chrono::milliseconds(static_cast<std::int64_t>(milliseconds));
}

}  // namespace meshgauge::check
