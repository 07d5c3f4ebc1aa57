#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/expectations.h"
#include "api/gate.h"
#include "api/json_filter.h"
#include "api/refused.h"
#include "api/request.h"

namespace meshgauge::api {
namespace {

using JsonValue = nlohmann::json;

constexpr Range kVolumeRange{};  // and of a share of it
constexpr std::string_view kCountMembers[] = {"min", "max"};
constexpr std::string_view kVolumeMembers[] = {"min", "max", "within"};

Error misfit(const std::string& pointer, const std::string& what) {
  return refused(pointer + " " + what, "options", pointer);
}

std::string joined(std::span<const std::string_view> names) {
  std::string list;
  for (const std::string_view name : names) list.append(list.empty() ? "" : ", ").append(name);
  return list;
}

Result<Done> read_end(const JsonValue& value, const Range& range, const std::string& pointer,
                      std::optional<double>& out) {
  if (!value.is_number()) return misfit(pointer, "must be a number, not " + shown(value));
  const auto number = in_range(value.get<double>(), range, pointer);
  if (!number) return number.error();
  return out = *number, Done{};
}

// Refuses what is not an object of at least one of the members, and of no other.
Result<Done> check_members(const JsonValue& value, std::span<const std::string_view> known, const std::string& pointer,
                           std::string_view or_else = "") {
  if (!value.is_object() || value.empty())
    return misfit(pointer, "must be " + std::string(or_else) + "an object of at least one of " + joined(known) +
                               ", not " + (value.is_object() ? "an empty one" : shown(value)));
  for (const auto& [key, member] : value.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      return refused("unknown option " + shown_text(pointer + "/" + key) + "; known: " + joined(known), "options",
                     pointer + "/" + key);
  }
  return Done{};
}

Result<Done> read_span(const JsonValue& value, const Range& range, const std::string& pointer, Span& span) {
  for (const auto& [name, end] : {std::pair("min", &span.min), std::pair("max", &span.max)}) {
    if (!value.contains(name)) continue;
    if (auto ok = read_end(value[name], range, pointer + "/" + name, *end); !ok) return ok;
  }
  if (span.min && span.max && *span.min > *span.max) return misfit(pointer, "has a min above its max");
  return Done{};
}

using ExpectReader = Result<Done> (*)(const JsonValue& value, const std::string& pointer, Expectations& expect);

template <std::optional<bool> Expectations::*expected>
Result<Done> read_truth(const JsonValue& value, const std::string& pointer, Expectations& expect) {
  if (!value.is_boolean()) return misfit(pointer, "must be true or false, not " + shown(value));
  return expect.*expected = value.get<bool>(), Done{};
}

// A number, or an object of min and max.
template <std::optional<Span> Expectations::*expected>
Result<Done> read_count(const JsonValue& value, const std::string& pointer, Expectations& expect) {
  Span& span = (expect.*expected).emplace();
  if (value.is_number()) {
    auto ok = read_end(value, kCountRange, pointer, span.min);
    span.max = span.min;
    return ok;
  }
  if (auto ok = check_members(value, kCountMembers, pointer, "a whole number, or "); !ok) return ok;
  return read_span(value, kCountRange, pointer, span);
}

Result<Done> read_volume(const JsonValue& value, const std::string& pointer, Expectations& expect) {
  if (auto ok = check_members(value, kVolumeMembers, pointer); !ok) return ok;
  Span span;
  if (auto ok = read_span(value, kVolumeRange, pointer, span); !ok) return ok;
  if (span.min || span.max) expect.volume = span;
  if (!value.contains("within")) return Done{};
  return read_end(value["within"], kVolumeRange, pointer + "/within", expect.volume_within);
}

constexpr std::string_view kExpectMembers[] = {"watertight", "oriented",   "triangles",
                                               "degenerate", "components", "volume"};
constexpr std::array<ExpectReader, std::size(kExpectMembers)> kExpectReaders{
    read_truth<&Expectations::watertight>, read_truth<&Expectations::oriented>,   read_count<&Expectations::triangles>,
    read_count<&Expectations::degenerate>, read_count<&Expectations::components>, read_volume};

nlohmann::ordered_json span_of(const Span& span) {
  auto json = nlohmann::ordered_json::object();
  if (span.min) json["min"] = *span.min;
  if (span.max) json["max"] = *span.max;
  return json;
}

nlohmann::ordered_json count_of(const Span& span) {
  auto json = span.min && span.min == span.max ? nlohmann::ordered_json(*span.min) : span_of(span);
  for (auto& end : json) end = static_cast<std::uint64_t>(end.get<double>());  // in kCountRange, of whole numbers
  return json;
}

}  // namespace

Result<Expectations> read_expect(const JsonValue& value, const std::string& pointer) {
  if (auto ok = check_members(value, kExpectMembers, pointer); !ok) return std::move(ok).error();
  Expectations expect;
  for (std::size_t i = 0; i < std::size(kExpectMembers); ++i) {
    const std::string key(kExpectMembers[i]);
    if (!value.contains(key)) continue;
    if (auto ok = kExpectReaders[i](value[key], pointer + "/" + key, expect); !ok) return std::move(ok).error();
  }
  return expect;
}

nlohmann::ordered_json json_of(const std::vector<Expectation>& expectations) {
  auto json = nlohmann::ordered_json::array();
  for (const Expectation& one : expectations)
    json.push_back(
        {{"name", one.name}, {"verdict", to_string(one.verdict)}, {"found", one.found}, {"expected", one.expected}});
  return json;
}

nlohmann::ordered_json json_of(const Expectations& expect) {
  auto json = nlohmann::ordered_json::object();
  if (expect.watertight) json["watertight"] = *expect.watertight;
  if (expect.oriented) json["oriented"] = *expect.oriented;
  if (expect.triangles) json["triangles"] = count_of(*expect.triangles);
  if (expect.degenerate) json["degenerate"] = count_of(*expect.degenerate);
  if (expect.components) json["components"] = count_of(*expect.components);
  if (expect.volume) json["volume"] = span_of(*expect.volume);
  if (expect.volume_within) json["volume"]["within"] = *expect.volume_within;
  return json;
}

}  // namespace meshgauge::api
