#include "api/options/quantity.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <nlohmann/json.hpp>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/options/asked_units.h"

namespace meshgauge::api {
namespace {

std::string text_of(double x) {
  if (!std::isfinite(x)) return std::isnan(x) ? "NaN" : "infinite";
  const bool whole = std::nearbyint(x) == x && std::abs(x) < 1e15;
  return whole ? std::to_string(static_cast<std::int64_t>(x)) : nlohmann::json(x).dump();
}

struct Quantity {
  double number = 0;
  std::string_view unit;
};

// Splits a decimal number from the text behind it. "inf" and "nan" are not numbers.
std::optional<Quantity> split(std::string_view text) {
  text = trimmed(text);
  const std::size_t digit = text.find_first_not_of("+-.");
  if (digit == std::string_view::npos || !is_digit(text[digit])) return std::nullopt;
  Quantity quantity;
  const char* end = text.data() + text.size();
  const char* next = parse_number(text.data(), end, quantity.number);
  if (!next) return std::nullopt;
  quantity.unit = trimmed({next, static_cast<std::size_t>(end - next)});
  return quantity;
}

Error no_length(std::string_view text, bool or_share) {
  const bool comma = text.find(',') != std::string_view::npos;
  return refused("must be " + std::string(or_share ? kLengthOrShare : kLength) + ", not " + shown_text(text) +
                 (comma ? "; write the decimals behind a point" : ""));
}

}  // namespace

std::string described(const Range& range) {
  if (range.integer) return "an integer from " + text_of(range.low) + " to " + text_of(range.high);
  if (range.low == -Range{}.high) return "a finite number of at most " + text_of(range.high);
  if (range.high < Range{}.high) return "a number from " + text_of(range.low) + " to " + text_of(range.high);
  return "a finite number of at least " + text_of(range.low);
}

Result<double> in_range(double value, const Range& range, std::string_view name) {
  const bool whole = !range.integer || std::nearbyint(value) == value;
  if (value >= range.low && value <= range.high && whole) return value;  // false for NaN
  return refused(std::string(name) + " must be " + described(range) + ", not " + text_of(value), "options",
                 std::string(name));
}

Result<Length> parse_length(std::string_view text, bool or_share) {
  const auto quantity = split(text);
  if (!quantity) return no_length(text, or_share);
  Length length;
  length.is_share = or_share && quantity->unit == "%";
  // Text behind the number must be a unit: "5e-", "0,05" and "0x10" are mistakes, not the numbers that they begin with.
  if (!quantity->unit.empty() && !length.is_share) {
    length.unit = parse_unit(quantity->unit);
    const bool word = std::all_of(quantity->unit.begin(), quantity->unit.end(), is_letter);
    if (!length.unit && !word) return no_length(text, or_share);
    if (!length.unit)
      return refused("must have a unit of length (" + unit_names() + ") behind the number" +
                     (or_share ? ", or '%' for a share of the baseline's diagonal" : "") + ", not " + shown_text(text));
  }
  if (!in_range(quantity->number, kMaxDistanceRange, "").ok())
    return refused("must be a finite number of at least 0, not " + shown_text(text));
  return length.number = length.is_share ? quantity->number / 100 : quantity->number, length;
}

Result<double> parse_share(std::string_view text, std::string_view of) {
  const auto quantity = split(text);
  if (!quantity || quantity->unit != "%")
    return refused("must be a share of " + std::string(of) + " in percent (1 %), not " + shown_text(text));
  if (!(quantity->number >= 0 && quantity->number <= 100))
    return refused("must be from 0 % to 100 %, not " + shown_text(text));
  return quantity->number / 100;
}

Result<std::chrono::milliseconds> parse_duration(std::string_view text, std::chrono::milliseconds most) {
  const auto quantity = split(text);
  const auto factor = [&]() -> std::optional<double> {
    if (!quantity) return std::nullopt;
    if (quantity->unit.empty() || quantity->unit == "s") return 1000;
    if (quantity->unit == "ms") return 1;
    return quantity->unit == "min" ? std::optional<double>(60'000) : std::nullopt;
  }();
  if (!factor) return refused("must be a time, as 60 s, 500 ms, 2 min or a number of seconds, not " + shown_text(text));
  const double milliseconds = std::nearbyint(quantity->number * *factor);
  const Range range{kTimeoutMsRange.low, static_cast<double>(most.count())};
  if (!in_range(milliseconds, range, "").ok()) {
    const bool whole = most.count() % 1000 == 0;
    const std::string end = whole ? std::to_string(most.count() / 1000) + " s" : std::to_string(most.count()) + " ms";
    return refused("must be from 1 ms to " + end + ", not " + shown_text(text));
  }
  return std::chrono::milliseconds(static_cast<std::int64_t>(milliseconds));
}

}  // namespace meshgauge::api
