#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "api/options/parts.h"
#include "api/options/quantity.h"

namespace meshgauge::api {
namespace {

constexpr Range kVolumeRange{};  // and of a share of it

using Member = Reading::Member;

// 20000.0 is a whole number, too.
JsonValue as_whole(const JsonValue& value) {
  const bool is_whole = value.is_number_float() && std::trunc(value.get<double>()) == value.get<double>();
  const bool fits = is_whole && std::abs(value.get<double>()) < 0x1p53;
  return fits ? JsonValue(static_cast<std::int64_t>(value.get<double>())) : value;
}

// Reads what `value` has of both ends; `others`: further members.
Span read_span(const JsonValue& value, const Range& range, std::vector<Member> others, std::string_view or_else,
               const std::string& at, Reading& reading) {
  Span span;
  std::vector<Member> members{
      {"min",
       [&](const JsonValue& v, const std::string& place) { span.min = reading.number(as_whole(v), range, place); }},
      {"max",
       [&](const JsonValue& v, const std::string& place) { span.max = reading.number(as_whole(v), range, place); }}};
  std::ranges::move(others, std::back_inserter(members));
  reading.some_members(value, members, at, or_else);
  if (span.min && span.max && *span.min > *span.max) reading.refuse(at, "has a min above its max");
  return span;
}

// A number, or an object of min and max.
Member count(std::string_view key, std::optional<Span>& expected, Reading& reading) {
  return {key, [&](const JsonValue& value, const std::string& at) {
            if (!value.is_number()) {
              expected = read_span(value, kCountRange, {}, "a whole number, or ", at, reading);
            } else if (const auto number = reading.number(as_whole(value), kCountRange, at)) {
              expected = Span{number, number};
            }
          }};
}

std::optional<double> read_within(const JsonValue& value, const std::string& at, Reading& reading) {
  if (!value.is_string() && !reading.surface.by_hand) return reading.number(value, kVolumeRange, at);
  const auto found =
      value.is_string() ? parse_length(value.get_ref<const std::string&>(), true) : Result<Length>(Error{});
  if (found && found->is_share) return found->number;
  reading.refuse(at, "must be a share of the volume of " + std::string(reading.surface.b) + ", as 1 %, not " +
                         reading.shown(value));
  return std::nullopt;
}

}  // namespace

Expectations read_expect(const JsonValue& value, const std::string& at, Reading& reading) {
  Expectations expect;
  const auto volume = [&](const JsonValue& v, const std::string& place) {
    const auto within = [&](const JsonValue& share, const std::string& where) {
      expect.volume_within = read_within(share, where, reading);
    };
    const Span span = read_span(v, kVolumeRange, {{"within", within}}, "", place, reading);
    if (span.min || span.max) expect.volume = span;
  };
  const Member members[] = {
      reading.boolean_into("watertight", expect.watertight), reading.boolean_into("oriented", expect.oriented),
      count("triangles", expect.triangles, reading),         count("degenerate", expect.degenerate, reading),
      count("components", expect.components, reading),       {"volume", volume}};
  reading.some_members(value, members, at);
  return expect;
}

}  // namespace meshgauge::api
