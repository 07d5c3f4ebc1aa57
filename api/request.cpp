#include "api/request.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <nlohmann/json.hpp>

#include "api/align.h"
#include "api/gate.h"
#include "api/json_filter.h"
#include "api/names.h"
#include "api/refused.h"
#include "api/region_json.h"
#include "api/request_words.h"

namespace meshgauge::api {
namespace {

using JsonValue = nlohmann::json;

Error invalid(std::string_view where, std::string message) {
  return refused(std::move(message), "options", std::string(where));
}

std::string text_of(double x) {
  if (!std::isfinite(x)) return std::isnan(x) ? "NaN" : "infinite";
  const bool whole = std::nearbyint(x) == x && std::abs(x) < 1e15;
  return whole ? std::to_string(static_cast<std::int64_t>(x)) : JsonValue(x).dump();
}

std::string described(const Range& range) {
  if (range.integer) return "an integer from " + text_of(range.low) + " to " + text_of(range.high);
  if (range.low == -Range{}.high) return "a finite number of at most " + text_of(range.high);
  if (range.high < Range{}.high) return "a number from " + text_of(range.low) + " to " + text_of(range.high);
  return "a finite number of at least " + text_of(range.low);
}

struct Reading {
  Request& request;
  const RequestLimits& limits;
  bool points_given = false;
};

using Reader = Result<Done> (*)(const JsonValue& value, const std::string& pointer, Reading& reading);

struct Field {
  std::string_view key;
  Reader read;
};

std::string keys_of(std::span<const Field> fields) {
  std::string list;
  for (const Field& field : fields) list.append(list.empty() ? "" : ", ").append(field.key);
  return list;
}

const Field* find(std::span<const Field> fields, std::string_view key) {
  const auto found = std::ranges::find(fields, key, &Field::key);
  return found == fields.end() ? nullptr : &*found;
}

// Returns the message for an unknown member.
std::string unknown(const std::string& pointer, const std::string& key, std::span<const Field> fields) {
  if (pointer == "/shards") {
    return "/shards is not an option: the threads of one worker share a comparison; leave it out, or set /threads";
  }
  return "unknown option " + shown_text(key) + "; known: " + keys_of(fields);
}

Result<Done> read_object(const JsonValue& value, const std::string& pointer, std::span<const Field> fields,
                         Reading& reading) {
  const std::string name = pointer.empty() ? "the document" : pointer;
  if (!value.is_object()) return invalid(pointer, name + " must be an object, not " + shown(value));
  for (const auto& [key, member] : value.items()) {
    const Field* field = find(fields, key);
    const std::string place = pointer + "/" + key;
    if (!field) return invalid(place, unknown(place, key, fields));
    if (auto read = field->read(member, place, reading); !read) return read;
  }
  return Done{};
}

Result<double> read_number(const JsonValue& value, const Range& range, const std::string& pointer) {
  if (range.integer ? value.is_number_integer() : value.is_number()) {
    return in_range(value.get<double>(), range, pointer);
  }
  return invalid(pointer, pointer + " must be " + described(range) + ", not " + shown(value));
}

template <class Number>
Result<Done> read_number(const JsonValue& value, const Range& range, const std::string& pointer, Number& out) {
  const auto number = read_number(value, range, pointer);
  if (!number) return number.error();
  out = static_cast<Number>(*number);
  return Done{};
}

Result<Done> read_boolean(const JsonValue& value, const std::string& pointer, bool& out) {
  if (!value.is_boolean()) return invalid(pointer, pointer + " must be true or false, not " + shown(value));
  out = value.get<bool>();
  return Done{};
}

template <class Enum, std::size_t N>
Result<Done> read_name(const Name<Enum> (&table)[N], const JsonValue& value, const std::string& pointer, Enum& out) {
  if (value.is_string()) {
    if (const auto found = value_of(table, value.get_ref<const std::string&>())) return out = *found, Done{};
  }
  return invalid(pointer, pointer + " must be one of " + list_of(table) + ", not " + shown(value));
}

template <std::optional<double> Tolerance::*rule>
Result<Done> read_rule(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_number(value, kToleranceRange, pointer, reading.request.options.tolerance.*rule);
}

Result<Done> read_tolerance(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {{"absolute", read_rule<&Tolerance::absolute>},
                                      {"diagonal", read_rule<&Tolerance::diagonal>},
                                      {"relative", read_rule<&Tolerance::relative>}};
  reading.request.options.tolerance = Tolerance{};
  if (auto read = read_object(value, pointer, kFields, reading); !read) return read;
  if (value.empty()) return invalid(pointer, pointer + " must have at least one of " + keys_of(kFields));
  return Done{};
}

Result<Done> read_max_distance(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_number(value, kMaxDistanceRange, pointer, reading.request.options.max_distance);
}

Result<Done> read_unit(const JsonValue& value, const std::string& pointer, std::optional<LengthUnit>& out) {
  if (value.is_string()) out = parse_unit(value.get_ref<const std::string&>());
  if (out) return Done{};
  return invalid(pointer, pointer + " must be a unit of length (" + std::string(kUnitNames) + "), not " + shown(value));
}

// Reads the unit of the limit. "b": the unit of mesh b, known or not.
Result<Done> read_gate_unit(const JsonValue& value, const std::string& pointer, Reading& reading) {
  AskedUnits& units = reading.request.options.units;
  if (value == kUnitOfB) return units.limit_of_b = true, Done{};
  return read_unit(value, pointer, units.limit);
}

template <std::optional<LengthUnit> AskedUnits::*unit>
Result<Done> read_mesh_unit(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_unit(value, pointer, reading.request.options.units.*unit);
}

Result<Done> read_units(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {{"a", read_mesh_unit<&AskedUnits::a>}, {"b", read_mesh_unit<&AskedUnits::b>}};
  return read_object(value, pointer, kFields, reading);
}

template <auto option>
Result<Done> read_switch(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_boolean(value, pointer, reading.request.options.*option);
}

template <auto asked, auto number, const Range& range>
Result<Done> read_setting(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_number(value, range, pointer, (*(reading.request.options.*asked)).*number);
}

Result<Done> read_max_share_beyond(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {
      {"distance", read_setting<&ComparisonOptions::max_share_beyond, &ShareLimit::distance, kBeyondRange>},
      {"share", read_setting<&ComparisonOptions::max_share_beyond, &ShareLimit::share, kShareRange>}};
  reading.request.options.max_share_beyond.emplace();
  if (auto read = read_object(value, pointer, kFields, reading); !read) return read;
  if (value.size() < 2) return invalid(pointer, pointer + " needs distance and share");
  return Done{};
}

// [-inside, outside]
Result<Done> read_zone(const JsonValue& value, const std::string& pointer, Reading& reading) {
  if (!value.is_array() || value.size() != 2)
    return invalid(pointer, pointer + " must be two numbers, such as [-0.05, 0.1], not " +
                                (value.is_array() ? "an array of " + std::to_string(value.size()) : shown(value)));
  constexpr Range kInside{-Range{}.high, 0};
  const auto inside = read_number(value[0], kInside, pointer + "/0");
  if (!inside) return inside.error();
  const auto outside = read_number(value[1], kMaxDistanceRange, pointer + "/1");
  if (!outside) return outside.error();
  reading.request.options.zone = SideOptions::Zone{std::abs(*inside), *outside};
  return Done{};
}

Result<Done> read_uncertainty(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_number(value, kMaxDistanceRange, pointer, reading.request.options.uncertainty);
}

Result<Done> read_gate(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {{"max_distance", read_max_distance},
                                      {"max_share_beyond", read_max_share_beyond},
                                      {"zone", read_zone},
                                      {"uncertainty", read_uncertainty},
                                      {"units", read_gate_unit},
                                      {"narrow", read_switch<&Options::narrow>}};
  if (auto read = read_object(value, pointer, kFields, reading); !read) return read;
  if (!has_limit(reading.request.options))
    return invalid(pointer, pointer + " needs max_distance, max_share_beyond or zone");
  return Done{};
}

Result<Done> read_work_items(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_number(value, kWorkItemsRange, pointer, reading.request.options.max_work_items);
}

Result<Done> read_memory_bytes(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_number(value, kMemoryBytesRange, pointer, reading.request.options.max_memory_bytes);
}

Result<Done> read_budget(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {{"work_items", read_work_items}, {"memory_bytes", read_memory_bytes}};
  return read_object(value, pointer, kFields, reading);
}

// Reads the request for something: true or an object of settings; false: none.
template <class Settings>
Result<Done> read_settings(std::optional<Settings>& asked, const JsonValue& value, const std::string& pointer,
                           std::span<const Field> fields, Reading& reading) {
  if (value.is_boolean()) {
    if (value.get<bool>()) asked.emplace();
    return Done{};
  }
  if (!value.is_object()) return invalid(pointer, pointer + " must be true, false or an object, not " + shown(value));
  asked.emplace();
  return read_object(value, pointer, fields, reading);
}

Result<Done> read_statistics(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {
      {"samples", read_setting<&Options::statistics, &Sampling::samples, kSamplesRange>},
      {"seed", read_setting<&Options::statistics, &Sampling::seed, kSeedRange>}};
  return read_settings(reading.request.options.statistics, value, pointer, kFields, reading);
}

// Reads an array of 1 to `most` numbers, each handed to `add`.
template <class Add>
Result<Done> read_list(const JsonValue& value, const Range& range, std::size_t most, const std::string& pointer,
                       const Add& add) {
  if (!value.is_array() || value.empty() || value.size() > most) {
    return invalid(pointer, pointer + " must be an array of 1 to " + std::to_string(most) + " numbers, not " +
                                (value.is_array() ? "one of " + std::to_string(value.size()) : shown(value)));
  }
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto number = read_number(value[i], range, pointer + "/" + std::to_string(i));
    if (!number) return number.error();
    add(*number);
  }
  return Done{};
}

Result<Done> read_beyond(const JsonValue& value, const std::string& pointer, Reading& reading) {
  auto& beyond = reading.request.options.areas->beyond;
  return read_list(value, kBeyondRange, AreaOptions::kMaxBeyond, pointer, [&](double distance) {
    beyond.push_back({distance, std::nullopt});
  });
}

Result<Done> read_quantiles(const JsonValue& value, const std::string& pointer, Reading& reading) {
  auto& quantiles = reading.request.options.areas->quantiles;
  return read_list(value, kQuantileRange, AreaOptions::kMaxQuantiles, pointer,
                   [&](double share) { quantiles.push_back(share); });
}

Result<Done> read_mean(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_boolean(value, pointer, reading.request.options.areas->mean);
}

Result<Done> read_areas(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {
      {"beyond", read_beyond},
      {"quantiles", read_quantiles},
      {"mean", read_mean},
      {"share_tolerance", read_setting<&Options::areas, &AreaOptions::share_tolerance, kShareToleranceRange>},
      {"length_tolerance", read_setting<&Options::areas, &AreaOptions::length_tolerance, kLengthToleranceRange>}};
  const AreaOptions& asked = reading.request.options.areas.emplace();
  if (auto read = read_object(value, pointer, kFields, reading); !read) return read;
  if (!asks_something(asked)) return invalid(pointer, pointer + " must ask for beyond, quantiles or mean");
  return Done{};
}

Result<Done> read_sides(const JsonValue& value, const std::string& pointer, Reading& reading) {
  static constexpr Field kFields[] = {
      {"length_tolerance", read_setting<&Options::sides, &SideOptions::length_tolerance, kLengthToleranceRange>}};
  return read_settings(reading.request.options.sides, value, pointer, kFields, reading);
}

template <auto option, auto read>
Result<Done> read_option(const JsonValue& value, const std::string& pointer, Reading& reading) {
  auto asked = read(value, pointer);
  if (!asked) return std::move(asked).error();
  return reading.request.options.*option = *std::move(asked), Done{};
}

Result<Done> read_direction(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_name(kDirections, value, pointer, reading.request.options.direction);
}

Result<Done> read_strategy(const JsonValue& value, const std::string& pointer, Reading& reading) {
  return read_name(kStrategies, value, pointer, reading.request.options.strategy);
}

Result<Done> read_points(const JsonValue& value, const std::string& pointer, Reading& reading) {
  if (!value.is_number()) return invalid(pointer, pointer + " must be a number, not " + shown(value));
  auto points = as_points(value.get<double>(), pointer);
  if (!points) return points.error();
  reading.request.options.points = *points;
  reading.points_given = true;
  return Done{};
}

Result<Done> read_timeout(const JsonValue& value, const std::string& pointer, Reading& reading) {
  const Range range{kTimeoutMsRange.low, static_cast<double>(reading.limits.max_timeout.count()), true};
  auto number = read_number(value, range, pointer);
  if (!number) return number.error();
  reading.request.timeout = std::chrono::milliseconds(static_cast<std::int64_t>(*number));
  return Done{};
}

Result<Done> read_threads(const JsonValue& value, const std::string& pointer, Reading& reading) {
  reading.request.threads_given = true;
  return read_number(value, kThreadsRange, pointer, reading.request.options.threads);
}

constexpr Field kOptions[] = {{"direction", read_direction},
                              {"tolerance", read_tolerance},
                              {"gate", read_gate},
                              {"strategy", read_strategy},
                              {"points", read_points},
                              {"timeout_ms", read_timeout},
                              {"threads", read_threads},
                              {"budget", read_budget},
                              {"areas", read_areas},
                              {"sides", read_sides},
                              {"statistics", read_statistics},
                              {"topology", read_switch<&ComparisonOptions::topology>},
                              {"units", read_units},
                              {"regions", read_option<&Options::regions, read_regions>},
                              {"align", read_option<&ComparisonOptions::align, api::read_align>},
                              {"expect", read_option<&ComparisonOptions::expect, read_expect>}};

}  // namespace

Result<double> in_range(double value, const Range& range, std::string_view name) {
  const bool whole = !range.integer || std::nearbyint(value) == value;
  if (value >= range.low && value <= range.high && whole) return value;  // false for NaN
  return invalid(name, std::string(name) + " must be " + described(range) + ", not " + text_of(value));
}

Result<int> as_points(double value, std::string_view name) {
  const int points = value >= 1 && value <= 1e6 && std::nearbyint(value) == value ? static_cast<int>(value) : 0;
  if (is_stencil(points)) return points;
  return invalid(name, std::string(name) + " must be one of 4, 10, 31, 109, 409, 1585, not " + text_of(value));
}

Result<std::string_view> as_simd(std::string_view value, std::string_view name) {
  const auto all = supported_simd();
  if (value == "auto") return all.front();
  for (const std::string_view supported : all) {
    if (value == supported) return supported;
  }
  return invalid(
      name, std::string(name) + " must be one of " + simd_names() + " on this processor, not " + shown_text(value));
}

std::string simd_names() {
  std::string list = "auto";
  for (const std::string_view name : supported_simd()) list.append(", ").append(name);
  return list;
}

Result<Done> check_points(bool points_given, Strategy strategy, std::string_view name) {
  if (!points_given || strategy == Strategy::n_point) return Done{};
  return invalid(name, std::string(name) + " goes with the strategy n_point only");
}

Result<Request> parse_options(std::string_view json, const RequestLimits& limits) {
  auto document = parse_document(json, "options", kMaxOptionsBytes);
  if (!document) return document.error();
  if (auto ok = resolve_words(*document); !ok) return ok.error();
  Request request;
  request.timeout = limits.default_timeout;
  Reading reading{request, limits};
  if (auto read = read_object(*document, "", kOptions, reading); !read) return read.error();
  if (auto ok = check_uncertainty(request.options, "/gate/uncertainty"); !ok) return ok.error();
  if (auto ok = check_limits_of_regions(request.options, "/regions"); !ok) return ok.error();
  if (auto ok = check_groups(request.options, "/regions"); !ok) return ok.error();
  if (auto ok = check_points(reading.points_given, request.options.strategy, "/points"); !ok) return ok.error();
  if (auto ok = check_sides(request.options, request.options.zone ? "/gate/zone" : "/sides"); !ok) return ok.error();
  return request;
}

}  // namespace meshgauge::api
