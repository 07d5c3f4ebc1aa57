#include "check/manifest/settings.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/align.h"
#include "api/formats/text.h"
#include "api/json_filter.h"
#include "api/names.h"
#include "api/refused.h"
#include "api/request.h"
#include "api/suggestion.h"
#include "check/manifest/expect_setting.h"
#include "check/manifest/names.h"
#include "check/manifest/quantities.h"
#include "check/manifest/region_setting.h"

namespace meshgauge::check {
namespace {

using Kind = YamlNode::Kind;

std::optional<double> number_of(const YamlNode& node) {
  if (node.kind != Kind::word || node.text.empty()) return std::nullopt;
  double number = 0;
  const char* end = node.text.data() + node.text.size();
  if (api::is_letter(node.text.front()) || api::parse_number(node.text.data(), end, number) != end) return std::nullopt;
  return number;
}

std::optional<double> read_number(const Setting& setting, const char* what, Mistakes& mistakes) {
  const auto number = number_of(setting.value);
  if (!number) refuse(setting, std::string("must be ") + what + ", not " + shown(setting.value), mistakes);
  return number;
}

template <class Enum, std::size_t N>
void read_name(const api::Name<Enum> (&table)[N], const Setting& setting, Enum& out, Mistakes& mistakes) {
  if (setting.value.is_text()) {
    if (const auto found = api::value_of(table, setting.value.text)) {
      out = *found;
      return;
    }
  }
  std::vector<std::string_view> names;
  for (const auto& row : table) names.push_back(row.text);
  const std::string_view meant = api::nearest(setting.value.text, names);
  refuse(setting,
         "must be one of " + api::list_of(table) + ", not " + shown(setting.value) +
             (meant.empty() ? "" : "; did you mean '" + std::string(meant) + "'?"),
         mistakes);
}

// Returns the value; nullopt: it is no text, or `parse` refuses it.
template <class Parse>
auto read_quantity(const Setting& setting, const Parse& parse, const char* what, Mistakes& mistakes) {
  auto parsed = parse(setting.value.text);
  if (setting.value.is_text() && parsed) return std::optional(*parsed);
  refuse(setting,
         setting.value.is_text() ? parsed.error().message
                                 : std::string("must be ") + what + ", not " + shown(setting.value),
         mistakes);
  return decltype(std::optional(*parsed))();
}

void read_max_distance(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.limit_given = true;
  if (const auto limit = read_quantity(setting, parse_limit, "a number", mistakes)) draft.gate.limit = *limit;
}

void read_max_share_beyond(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.limit_given = true;
  const YamlNode& map = setting.value;
  constexpr std::string_view kKnown[] = {"distance", "share"};
  if (map.kind != Kind::map)
    return refuse(setting, "must be a map of distance and share, as {distance: 0.05 mm, share: 1 %}, not " + shown(map),
                  mistakes);
  draft.beside = map.place;
  AreaLimit& limit = draft.gate.area_limit.emplace();
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Setting part{map.keys[i].text, map.items[i]};
    if (part.key == kKnown[0]) {
      limit.distance = read_quantity(part, parse_limit, "a number", mistakes).value_or(Limit{});
    } else if (part.key == kKnown[1]) {
      limit.share = read_quantity(part, parse_share, "a share of the area", mistakes).value_or(0);
    } else {
      mistakes.add(map.keys[i].place, "unknown key " + api::shown_text(part.key) + api::suggestion(part.key, kKnown));
    }
  }
  for (const std::string_view key : kKnown) {
    if (map.keys.size() < std::size(kKnown) &&
        std::none_of(map.keys.begin(), map.keys.end(), [&](const Written& w) { return w.text == key; }))
      refuse(setting, "has no " + std::string(key) + ": write {distance: 0.05 mm, share: 1 %}", mistakes);
  }
}

void read_zone(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.limit_given = true;
  const YamlNode& list = setting.value;
  if (list.kind != Kind::list || list.items.size() != 2)
    return refuse(setting,
                  "must be a list of two limits, inside and outside, as [-0.05 mm, 0.1 mm], not " + shown(list),
                  mistakes);
  draft.beside = list.place;
  const auto end = [&](std::size_t i) {
    const auto parse = [&](std::string_view text) { return parse_zone_end(text, i == 0); };
    return read_quantity({setting.key, list.items[i]}, parse, "a number", mistakes).value_or(Limit{});
  };
  const Limit inside = end(0), outside = end(1);
  draft.gate.zone = zone_of(inside, outside);
}

void read_uncertainty(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.beside = setting.value.place;
  if (const auto found = read_quantity(setting, parse_limit, "a number", mistakes)) draft.gate.uncertainty = *found;
}

void read_direction(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  read_name(kDirectionWords, setting, draft.gate.options.direction, mistakes);
}

void read_timeout(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  if (const auto timeout = read_quantity(setting, parse_duration, "a time", mistakes)) draft.gate.timeout = *timeout;
}

void read_strategy(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.own_strategy = true;
  read_name(api::kStrategies, setting, draft.gate.options.strategy, mistakes);
}

void read_points(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.own_points = true;
  draft.points = setting.value.place;
  const auto number = read_number(setting, "a whole number", mistakes);
  if (!number) return;
  const auto points = api::as_points(*number, setting.key);
  if (points) {
    draft.gate.options.points = *points;
  } else {
    mistakes.add(setting.value.place, points.error().message);
  }
}

using ToleranceRule = std::optional<double> Tolerance::*;
constexpr std::pair<std::string_view, ToleranceRule> kToleranceRules[] = {
    {"absolute", &Tolerance::absolute}, {"diagonal", &Tolerance::diagonal}, {"relative", &Tolerance::relative}};

void read_tolerance(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  const YamlNode& map = setting.value;
  constexpr std::string_view kKnown[] = {"absolute", "diagonal", "relative"};
  if (map.kind != Kind::map || map.keys.empty()) {
    return refuse(setting, "must be a map of at least one of absolute, diagonal, relative, not " + shown(map),
                  mistakes);
  }
  Tolerance& tolerance = draft.gate.options.tolerance;
  tolerance = {};  // as in the API: given members replace the defaults
  draft.gate.tolerance_given = true;
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const Written& key = map.keys[i];
    const auto rule = std::find_if(std::begin(kToleranceRules), std::end(kToleranceRules),
                                   [&](auto& r) { return r.first == key.text; });
    if (rule == std::end(kToleranceRules)) {
      mistakes.add(key.place, "unknown key " + api::shown_text(key.text) + api::suggestion(key.text, kKnown));
      continue;
    }
    const auto number = read_within({rule->first, map.items[i]}, api::kToleranceRange, mistakes);
    if (number) tolerance.*(rule->second) = *number;
  }
}

void read_threads(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  const auto threads = read_within(setting, api::kThreadsRange, mistakes);
  if (!threads) return;
  draft.gate.options.threads = static_cast<unsigned>(*threads);
  draft.gate.threads_given = true;
}

void read_statistics(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  if (const auto asked = read_boolean(setting, mistakes)) draft.gate.statistics = *asked;
}

// As the API reads it.
nlohmann::json as_json(const YamlNode& node) {
  nlohmann::json json;
  if (node.kind == Kind::map) {
    json = nlohmann::json::object();
    for (std::size_t i = 0; i < node.keys.size(); ++i) json[node.keys[i].text] = as_json(node.items[i]);
  } else if (node.kind == Kind::list) {
    json = nlohmann::json::array();
    for (const YamlNode& item : node.items) json.push_back(as_json(item));
  } else if (const auto number = number_of(node)) {
    json = *number;
  } else if (node.kind == Kind::word && (node.text == "true" || node.text == "false")) {
    json = node.text == "true";
  } else if (node.is_text()) {
    json = node.text;
  }
  return json;
}

void read_align(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  const auto asked = api::read_align(as_json(setting.value), std::string(setting.key));
  if (!asked) return mistakes.add(setting.value.place, asked.error().message);
  draft.gate.options.align = *asked;
}

void read_cloud(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  if (const auto may_be = read_boolean(setting, mistakes)) draft.gate.cloud = *may_be;
}

std::optional<LengthUnit> read_unit(std::string_view key, const YamlNode& value, Mistakes& mistakes) {
  const auto unit = value.is_text() ? parse_unit(value.text) : Result<LengthUnit>(Error{});
  if (unit) return *unit;
  const std::string why = value.is_text()
                              ? unit.error().message
                              : "must be a unit of length (" + std::string(api::kUnitNames) + "), not " + shown(value);
  mistakes.add(value.place, std::string(key) + " " + why);
  return std::nullopt;
}

// Reads one unit for both meshes, or a map with one for each.
void read_units(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  const YamlNode& value = setting.value;
  api::AskedUnits& units = draft.gate.options.units;
  units = {};  // as in the API: given members replace the defaults
  if (value.kind != Kind::map) {
    units.a = units.b = read_unit(setting.key, value, mistakes);
    return;
  }
  constexpr std::string_view kKnown[] = {"candidate", "baseline"};
  for (std::size_t i = 0; i < value.keys.size(); ++i) {
    const Written& key = value.keys[i];
    if (key.text != kKnown[0] && key.text != kKnown[1]) {
      mistakes.add(key.place, "unknown key " + api::shown_text(key.text) + api::suggestion(key.text, kKnown));
      continue;
    }
    (key.text == kKnown[0] ? units.a : units.b) = read_unit(key.text, value.items[i], mistakes);
  }
  if (value.keys.empty())
    refuse(setting, "must be a unit, or a map of candidate and baseline, not an empty map", mistakes);
}

void read_on_fail(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  read_name(kOnFail, setting, draft.gate.warn_only, mistakes);
}

void read_unmatched_baselines(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  read_name(kUnmatchedBaselines, setting, draft.unmatched_ignored, mistakes);
}

constexpr SettingReader kSettings[] = {{"max_distance", read_max_distance},
                                       {"max_share_beyond", read_max_share_beyond},
                                       {"zone", read_zone},
                                       {"uncertainty", read_uncertainty},
                                       {"regions", read_regions},
                                       {"direction", read_direction},
                                       {"cloud", read_cloud},
                                       {"align", read_align},
                                       {"timeout", read_timeout},
                                       {"strategy", read_strategy},
                                       {"points", read_points},
                                       {"tolerance", read_tolerance},
                                       {"threads", read_threads},
                                       {"statistics", read_statistics},
                                       {"expect", read_expect},
                                       {"units", read_units},
                                       {"on_fail", read_on_fail},
                                       {"unmatched_baselines", read_unmatched_baselines}};

}  // namespace

Result<std::optional<AlignOptions>> parse_align(std::string_view text, const std::string& name) {
  Mistakes mistakes;
  const auto tree = parse_yaml(text, mistakes);
  const auto found = std::move(mistakes).sorted();
  if (!found.empty()) return bad_flag(name, found.front().message);
  return api::read_align(as_json(*tree), name);
}

void refuse(const Setting& setting, const std::string& what, Mistakes& mistakes) {
  mistakes.add(setting.value.place, std::string(setting.key) + " " + what);
}

std::optional<double> read_within(const Setting& setting, const api::Range& range, Mistakes& mistakes) {
  const auto number = read_number(setting, range.integer ? "a whole number" : "a number", mistakes);
  if (!number) return std::nullopt;
  const auto checked = api::in_range(*number, range, setting.key);
  if (checked) return *checked;
  mistakes.add(setting.value.place, checked.error().message);
  return std::nullopt;
}

std::optional<bool> read_boolean(const Setting& setting, Mistakes& mistakes) {
  const YamlNode& value = setting.value;
  if (value.kind == Kind::word && (value.text == "true" || value.text == "false")) return value.text == "true";
  refuse(setting, "must be true or false, without quotes, not " + shown(value), mistakes);
  return std::nullopt;
}

std::span<const SettingReader> setting_readers() { return kSettings; }

void check_settings(const Draft& draft, Mistakes& mistakes) {
  if (const auto ok = check_limits(draft.gate); !ok) mistakes.add(draft.beside, ok.error().message);
  // `points` of the defaults applies to gates that keep the defaults' strategy.
  const bool counts = draft.points.line > 0 && (draft.own_points || !draft.own_strategy);
  if (!counts) return;
  const auto ok = api::check_points(true, draft.gate.options.strategy, "points");
  if (!ok) mistakes.add(draft.points, ok.error().message + ": write 'strategy: n_point', or leave points out");
}

std::string shown(const YamlNode& node) {
  if (node.kind == Kind::list) return "a list";
  if (node.kind == Kind::map) return node.keys.empty() ? "an empty map" : "a map";
  return node.kind == Kind::none ? "empty" : api::shown_text(node.text);
}

bool is_bare_value(const YamlNode& node) {
  const std::string_view text = node.text;
  if (node.kind != Kind::word) return false;
  return number_of(node) || api::same_word(text, "true") || api::same_word(text, "false");
}

}  // namespace meshgauge::check
