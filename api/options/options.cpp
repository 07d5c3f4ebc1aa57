// How each option is read and written, and its row of the table.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "api/base/figures.h"
#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/options/draft.h"
#include "api/options/names.h"
#include "api/options/parts.h"
#include "api/options/quantity.h"
#include "api/options/table.h"
#include "api/options/write_options.h"

namespace meshgauge::api {
namespace {

using Member = Reading::Member;

void read_direction(const JsonValue& value, const std::string& at, Draft& draft) {
  if (const auto found = draft.reading.name(kDirectionWords, value, at)) draft.options.direction = *found;
}

void read_strategy(const JsonValue& value, const std::string& at, Draft& draft) {
  if (const auto found = draft.reading.name(kStrategies, value, at)) draft.options.strategy = *found;
}

OptionWords stencils() { return {"4", "10", "31", "109", "409", "1585"}; }

void read_points(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.points_at = at;
  const double number = value.is_number() ? value.get<double>() : 0;
  const int points = number >= 1 && number <= 1e6 && std::nearbyint(number) == number ? static_cast<int>(number) : 0;
  if (!is_stencil(points))
    return draft.reading.refuse(
        at, "must be one of the numbers " + listed(stencils()) + ", not " + draft.reading.shown(value));
  draft.options.points = points;
}

void read_tolerance(const JsonValue& value, const std::string& at, Draft& draft) {
  Tolerance& tolerance = draft.options.tolerance = {};
  draft.tolerance_given = true;
  Reading& reading = draft.reading;
  const Member members[] = {reading.number_into("absolute", tolerance.absolute, kToleranceRange),
                            reading.number_into("diagonal", tolerance.diagonal, kToleranceRange),
                            reading.number_into("relative", tolerance.relative, kToleranceRange)};
  reading.some_members(value, members, at);
}

void read_milliseconds(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.timeout_at = at;
  const Range range{kTimeoutMsRange.low, static_cast<double>(draft.limits.max_timeout.count()), true};
  if (const auto found = draft.reading.number(value, range, at))
    draft.request.timeout = std::chrono::milliseconds(static_cast<std::int64_t>(*found));
}

// "60 s", or a number of seconds.
void read_timeout(const JsonValue& value, const std::string& at, Draft& draft) {
  if (!draft.timeout_at.empty())
    return draft.reading.refuse(at, "stands beside " + draft.reading.surface.name(draft.timeout_at) + ": write one");
  draft.timeout_at = at;
  const bool is_time = value.is_string() || value.is_number();
  if (!is_time) return draft.reading.refuse(at, "must be a time, not " + draft.reading.shown(value));
  const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  const auto found = parse_duration(text, draft.limits.max_timeout);
  if (found) {
    draft.request.timeout = *found;
  } else {
    draft.reading.refuse(at, found.error().message);
  }
}

void read_threads(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.request.threads_given = true;
  if (const auto found = draft.reading.number(value, kThreadsRange, at))
    draft.options.threads = static_cast<unsigned>(*found);
}

void read_budget(const JsonValue& value, const std::string& at, Draft& draft) {
  Reading& reading = draft.reading;
  const Member members[] = {reading.number_into("work_items", draft.options.max_work_items, kWorkItemsRange),
                            reading.number_into("memory_bytes", draft.options.max_memory_bytes, kMemoryBytesRange)};
  reading.members(value, members, at);
}

void read_areas(const JsonValue& value, const std::string& at, Draft& draft) {
  AreaOptions& areas = draft.options.areas.emplace();
  Reading& reading = draft.reading;
  const Member members[] = {
      {"beyond",
       [&](const JsonValue& list, const std::string& place) {
         reading.elements(
             list, 1, AreaOptions::kMaxBeyond, "numbers",
             [&](const JsonValue& v, const std::string& where) {
               areas.beyond.push_back({reading.number(v, kBeyondRange, where).value_or(0), std::nullopt});
             },
             place);
       }},
      {"quantiles",
       [&](const JsonValue& list, const std::string& place) {
         reading.elements(
             list, 1, AreaOptions::kMaxQuantiles, "numbers",
             [&](const JsonValue& v, const std::string& where) {
               areas.quantiles.push_back(reading.number(v, kQuantileRange, where).value_or(0.5));
             },
             place);
       }},
      reading.boolean_into("mean", areas.mean),
      reading.number_into("share_tolerance", areas.share_tolerance, kShareToleranceRange),
      reading.number_into("length_tolerance", areas.length_tolerance, kLengthToleranceRange)};
  const std::size_t mistakes = reading.mistakes.size();
  if (reading.members(value, members, at) && !asks_something(areas) && reading.mistakes.size() == mistakes)
    reading.refuse(at, "must ask for beyond, quantiles or mean");
}

// Reads the request for something: true or an object of settings, which are the members of `members(*asked)`; false:
// none.
template <class Settings, class Members>
void read_settings(std::optional<Settings>& asked, const JsonValue& value, const Members& members,
                   const std::string& at, Draft& draft) {
  if (value == false) return asked.reset();
  if (value != true && !value.is_object())
    return draft.reading.refuse(at, "must be true, false or " + std::string(draft.reading.surface.object) + ", not " +
                                        draft.reading.shown(value));
  asked.emplace();
  if (value.is_object()) draft.reading.members(value, members(*asked), at);
}

void read_sides(const JsonValue& value, const std::string& at, Draft& draft) {
  const auto members = [&](SideOptions& sides) {
    return std::array{draft.reading.number_into("length_tolerance", sides.length_tolerance, kLengthToleranceRange)};
  };
  read_settings(draft.options.sides, value, members, at, draft);
  if (draft.options.sides && draft.sides_at.empty()) draft.sides_at = at;
}

void read_statistics(const JsonValue& value, const std::string& at, Draft& draft) {
  const auto members = [&](Sampling& sampling) {
    return std::array{draft.reading.number_into("samples", sampling.samples, kSamplesRange),
                      draft.reading.number_into("seed", sampling.seed, kSeedRange)};
  };
  read_settings(draft.options.statistics, value, members, at, draft);
}

void read_topology(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.options.topology = draft.reading.boolean(value, at).value_or(false);
}

// One unit for both meshes, or an object with one for each, by either pair of names.
void read_units(const JsonValue& value, const std::string& at, Draft& draft) {
  AskedUnits& units = draft.options.units;
  if (!value.is_object()) {
    units.a = units.b = read_unit(value, at, draft.reading);
    return;
  }
  const auto unit = [&](std::string_view key, std::optional<LengthUnit>& out) {
    return Member{key, [&](const JsonValue& v, const std::string& place) { out = read_unit(v, place, draft.reading); }};
  };
  std::vector<Member> members;
  if (!draft.reading.surface.by_hand) members = {unit("a", units.a), unit("b", units.b)};
  members.push_back(unit("candidate", units.a));
  members.push_back(unit("baseline", units.b));
  if (draft.reading.surface.by_hand) {
    draft.reading.some_members(value, members, at, "a unit, or ");
  } else {
    draft.reading.members(value, members, at);
  }
}

void take_regions(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.options.regions = read_regions(value, at, draft.reading);
}

void take_align(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.options.align = read_align(value, at, draft.reading);
}

OptionLengths lengths_of_regions(ComparisonOptions& options) {
  OptionLengths lengths;
  for (Region& region : options.regions) {
    if (region.max_distance) lengths.push_back(&*region.max_distance);
  }
  return lengths;
}

void take_expect(const JsonValue& value, const std::string& at, Draft& draft) {
  draft.options.expect = read_expect(value, at, draft.reading);
}

// --- as it is written -------------------------------------------------------------------------------------------

Json or_null(Json members) {
  if (members.empty()) return nullptr;
  return members;
}

Json write_gate(const Request& request) {
  const Json limits = gate_of(request.options);
  if (limits.is_null()) return nullptr;
  Json gate = Json::object();
  for (const auto& [name, limit] : limits.items()) {
    if (!limit.is_null()) gate[name] = limit;
  }
  gate["narrow"] = request.options.narrow;
  return gate;
}

Json write_regions(const Request& request) {
  Json regions = Json::array();
  for (const Region& region : request.options.regions) regions.push_back(json_of(region));
  return or_null(std::move(regions));
}

Json units_of(const AskedUnits& declared) {
  Json json = Json::object();
  if (declared.a) json["a"] = to_string(*declared.a);
  if (declared.b) json["b"] = to_string(*declared.b);
  return json;
}

// Writes only what differs from the engine's defaults: the service may have a smaller limit.
Json budget_of(const Options& options) {
  const Options usual;
  Json json = Json::object();
  if (options.max_work_items != usual.max_work_items) json["work_items"] = options.max_work_items;
  if (options.max_memory_bytes != usual.max_memory_bytes) json["memory_bytes"] = options.max_memory_bytes;
  return json;
}

Json areas_of(const AreaOptions& areas) {
  Json json = Json::object();
  for (const AreaOptions::Beyond& beyond : areas.beyond) json["beyond"].push_back(beyond.distance);
  if (!areas.quantiles.empty()) json["quantiles"] = areas.quantiles;
  if (areas.mean) json["mean"] = true;
  json["share_tolerance"] = areas.share_tolerance;
  json["length_tolerance"] = areas.length_tolerance;
  return json;
}

// `true`: asked for as usual.
Json statistics_of(const Sampling& sampling) {
  const Sampling usual;
  if (sampling.samples == usual.samples && sampling.seed == usual.seed) return true;
  return {{"samples", sampling.samples}, {"seed", sampling.seed}};
}

// --- the table --------------------------------------------------------------------------------------------------

constexpr OtherOption kOptions[] = {
    {{.key = "gate",
      .surfaces = Surface::http,
      .help = "The limits in one object, with the unit of their numbers",
      .example = "{max_distance: 0.05, units: mm}",
      .read = read_gate},
     write_gate},
    {{.key = "regions",
      .surfaces = kEverywhere,
      .is_limit = true,
      .help = "Boxes, spheres and groups of {b} that are measured by themselves, some with a limit (docs/regions.md)",
      .example = "[{name: bore, box: {min: [0, 0, 0], max: [9, 9, 9]}, max_distance: 0.02 mm}]",
      .read = take_regions,
      .lengths = lengths_of_regions},
     write_regions},
    {{.key = "direction",
      .kind = OptionKind::choice,
      .surfaces = kEverywhere,
      .help = "From which mesh the distance is measured; symmetric is the larger of both",
      .usual = "symmetric",
      .words = words_of<kDirectionWords>,
      .read = read_direction},
     [](const Request& r) { return Json(name_of(kDirections, r.options.direction)); }},
    {{.key = "align",
      .surfaces = kEverywhere,
      .help = "How {a} is moved before it is measured, by the best fit or by a transform (docs/alignment.md)",
      .usual = "none",
      .example = "rigid",
      .read = take_align},
     [](const Request& r) { return r.options.align ? json_of(*r.options.align) : Json(nullptr); }},
    {{.key = "timeout_ms",
      .kind = OptionKind::count,
      .surfaces = kOfService,
      .help = "The timeout in milliseconds",
      .usual = "30000",
      .range = kTimeoutMsRange,
      .read = read_milliseconds},
     [](const Request& r) { return Json(r.timeout.count()); }},
    {{.key = "timeout",
      .kind = OptionKind::time,
      .surfaces = kEverywhere,
      .help = "The time after which the work ends, in seconds or with a unit (ms, s, min)",
      .usual = "30 s",
      .example = "60 s",
      .read = read_timeout},
     [](const Request&) { return Json(nullptr); }},  // as timeout_ms
    {{.key = "strategy",
      .kind = OptionKind::choice,
      .surfaces = kEverywhere,
      .help = "How the distance is bounded; auto is the fastest, the others are for comparing methods",
      .usual = "auto",
      .words = words_of<kStrategies>,
      .read = read_strategy},
     [](const Request& r) { return Json(name_of(kStrategies, r.options.strategy)); }},
    {{.key = "points",
      .kind = OptionKind::choice,
      .surfaces = kEverywhere,
      .help = "Samples a piece, for the strategy n_point",
      .usual = "4",
      .words = stencils,
      .read = read_points},
     [](const Request& r) { return r.options.strategy == Strategy::n_point ? Json(r.options.points) : Json(nullptr); }},
    {{.key = "tolerance",
      .surfaces = kEverywhere,
      .help = "How narrow the interval has to be; the first of these rules that holds ends the work",
      .usual = "{diagonal: 1.0e-6, relative: 0.01}",
      .example = "{relative: 0.001}",
      .read = read_tolerance},
     [](const Request& r) { return or_null(json_of(r.options.tolerance)); }},
    {{.key = "threads",
      .kind = OptionKind::count,
      .surfaces = kEverywhere,
      .help = "At most so many threads",
      .range = kThreadsRange,
      .read = read_threads},
     [](const Request& r) { return r.threads_given ? Json(r.options.threads) : Json(nullptr); }},
    {{.key = "budget",
      .surfaces = kOfService,
      .help = "The most work and memory of the search",
      .example = "{work_items: 1000000}",
      .read = read_budget},
     [](const Request& r) { return or_null(budget_of(r.options)); }},
    {{.key = "areas",
      .surfaces = kNotInGates,
      .help = "Certify how the distance is distributed over the area (docs/statistics.md)",
      .example = "{beyond: [0.05, 0.1], quantiles: [0.95, 0.99], mean: true}",
      .read = read_areas},
     [](const Request& r) { return r.options.areas ? areas_of(*r.options.areas) : Json(nullptr); }},
    {{.key = "sides",
      .surfaces = kNotInGates,
      .help = "Certify how far {a} reaches outside and inside of {b}, which must be closed",
      .usual = "false",
      .example = "true",
      .read = read_sides},
     [](const Request& r) {
       const auto& sides = r.options.sides;
       return sides ? Json{{"length_tolerance", sides->length_tolerance}} : Json(nullptr);
     }},
    {{.key = "statistics",
      .surfaces = kEverywhere,
      .help = "Sample mean, RMS, percentiles and a histogram as well (docs/statistics.md)",
      .usual = "false",
      .example = "{samples: 200000, seed: 7}",
      .read = read_statistics},
     [](const Request& r) { return r.options.statistics ? statistics_of(*r.options.statistics) : Json(nullptr); }},
    {{.key = "topology",
      .kind = OptionKind::toggle,
      .surfaces = kNotInGates,
      .help = "Also examine both meshes: open edges, orientation, components, volume",
      .usual = "false",
      .read = read_topology},
     [](const Request& r) { return r.options.topology ? Json(true) : Json(nullptr); }},
    {{.key = "expect",
      .surfaces = kEverywhere,
      .help = "What {a} itself has to be like (docs/check.md)",
      .example = "{watertight: true, triangles: {max: 20000}}",
      .read = take_expect},
     [](const Request& r) { return or_null(json_of(r.options.expect)); }},
    {{.key = "units",
      .surfaces = kEverywhere,
      .help = "The unit of both meshes, or of each, whatever their files say (docs/units.md)",
      .example = "mm",
      .read = read_units},
     [](const Request& r) { return or_null(units_of(r.options.units)); }}};

// --- what must fit each other -----------------------------------------------------------------------------------

void check_direction(Draft& draft) {
  const Surface& words = draft.reading.surface;
  const ComparisonOptions& options = draft.options;
  if (options.direction == Direction::b_to_a && !draft.sides_at.empty())
    draft.reading.refuse(draft.sides_at, "is about the points of " + std::string(words.a) +
                                             ": the direction must be symmetric or " + std::string(words.a_to_b));
  if (options.direction != Direction::a_to_b) return;
  for (std::size_t i = 0; i < options.regions.size(); ++i) {
    if (!options.regions[i].is_group()) continue;
    draft.reading.add("/regions/" + std::to_string(i) + "/group",
                      "the region " + shown_text(options.regions[i].name) + " is a group of " + std::string(words.b) +
                          ": the direction must be symmetric or " + std::string(words.b_to_a));
  }
}

void complete(Draft& draft) {
  complete_limits(draft);
  check_direction(draft);
  if (!draft.points_at.empty() && draft.options.strategy != Strategy::n_point)
    draft.reading.refuse(draft.points_at, "goes with the strategy n_point only: choose it, or leave " +
                                              draft.reading.surface.name(draft.points_at) + " out");
}

void read_members(const JsonValue& document, Draft& draft) {
  std::vector<Member> members;
  for (const LimitOption& option : limit_options()) {
    members.push_back({option.key, [read = option.read, &draft](const JsonValue& value, const std::string& at) {
                         if (draft.limits_at.empty()) draft.limits_at = at;
                         read(value, at, draft);
                       }});
  }
  for (const OtherOption& option : kOptions) {
    if ((option.surfaces & draft.reading.surface.bit) != 0) members.push_back(member(option.key, option.read, draft));
  }
  draft.reading.members(document, members, "");
}

}  // namespace

ReadRequest read_request(const nlohmann::json& document, const Surface& surface, const RequestLimits& limits) {
  Reading reading(surface);
  Draft draft{reading, limits};
  draft.request.timeout = limits.default_timeout;
  read_members(document, draft);
  complete(draft);
  return {std::move(draft.request), reading.told()};
}

const std::vector<const Option*>& all_options() {
  static const std::vector<const Option*> kRows = [] {
    std::vector<const Option*> rows;
    for (const LimitOption& option : limit_options()) rows.push_back(&option);
    for (const OtherOption& option : kOptions) rows.push_back(&option);
    return rows;
  }();
  return kRows;
}

Json json_of_length(double length, const ComparisonOptions& options) {
  if (length == 0) return nullptr;
  const auto& unit = options.units.limit;
  return has_limit(options) || !unit ? Json(length) : Json(with_unit(shortest(length), unit));
}

Json json_of(const Request& request) {
  Json json = Json::object();
  for (const OtherOption& option : kOptions) {
    if (Json value = option.write(request); !value.is_null()) json[std::string(option.key)] = std::move(value);
  }
  return json;
}

std::vector<RequestMistake> mistakes_in_part(const nlohmann::json& document, const Surface& surface) {
  const RequestLimits limits;
  Reading reading(surface);
  Draft draft{reading, limits};
  read_members(document, draft);
  return reading.told();
}

std::vector<std::string_view> options_of(const Surface& surface) {
  std::vector<std::string_view> keys;
  for (const Option* option : all_options()) {
    if ((option->surfaces & surface.bit) != 0) keys.push_back(option->key);
  }
  return keys;
}

Error error_of(const std::vector<RequestMistake>& mistakes) {
  Error error = refused(mistakes.front().message, "options", mistakes.front().pointer);
  for (std::size_t i = 1; i < mistakes.size(); ++i)
    error.others.push_back(refused(mistakes[i].message, "options", mistakes[i].pointer));
  return error;
}

Result<Request> parse_options(std::string_view json, const RequestLimits& limits, const Surface& surface) {
  const auto document = parse_document(json, "options", kMaxOptionsBytes);
  if (!document) return document.error();
  ReadRequest read = read_request(*document, surface, limits);
  if (!read.mistakes.empty()) return error_of(read.mistakes);
  return std::move(read.request);
}

Result<std::string_view> as_simd(std::string_view value, std::string_view name) {
  const auto all = supported_simd();
  if (value == "auto") return all.front();
  for (const std::string_view supported : all) {
    if (value == supported) return supported;
  }
  return refused(std::string(name) + " must be one of " + simd_names() + " on this processor, not " + shown_text(value),
                 "options", std::string(name));
}

std::string simd_names() {
  std::string list = "auto";
  for (const std::string_view name : supported_simd()) list.append(", ").append(name);
  return list;
}

}  // namespace meshgauge::api
