#include "check/manifest/quantities.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "api/formats/text.h"
#include "api/json_filter.h"
#include "api/request.h"
#include "check/text.h"
#include "check/utf8.h"

namespace meshgauge::check {
namespace {

using api::shown_text;

Error refused(std::string message) { return Error{ErrorCode::invalid_request, std::move(message), "", ""}; }

struct Quantity {
  double number = 0;
  std::string_view unit;
};

// A number in decimal and what stands behind it. Words for numbers ("inf", "nan") are none.
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

bool is_digit(char c) { return api::is_digit(c); }

// Shares of something in other words and signs: as labels they would make a limit of millimetres of "0.5 percent".
constexpr std::string_view kShares[] = {"percent", "percents", "percentage", "pct",      "perc",
                                        "prozent", "pourcent", "permille",   "promille", "ppm"};
constexpr std::string_view kShareSigns[] = {"\xD9\xAA", "\xE2\x80\xB0", "\xE2\x80\xB1", "\xEF\xB9\xAA",
                                            "\xEF\xBC\x85"};  // U+066A, U+2030, U+2031, U+FE6A, U+FF05

bool is_share(std::string_view unit) {
  const auto is = [&](std::string_view word) { return api::same_word(unit, word); };
  const auto holds = [&](std::string_view sign) { return unit.find(sign) != std::string_view::npos; };
  return std::any_of(std::begin(kShares), std::end(kShares), is) ||
         std::any_of(std::begin(kShareSigns), std::end(kShareSigns), holds);
}

// "5e-" and "5e" have lost the digits of their exponent.
bool is_broken_exponent(std::string_view unit) {
  if (unit.empty() || (unit[0] != 'e' && unit[0] != 'E')) return false;
  return unit.size() == 1 || unit[1] == '+' || unit[1] == '-';
}

// The point of "0,05" read as an end, or the x of "0x10" as a unit, would make another number of it.
bool is_label(std::string_view unit) {
  const auto begins = [](char c) { return api::is_letter(c) || static_cast<unsigned char>(c) >= 0x80; };
  const bool word = std::none_of(unit.begin(), unit.end(), [](char c) { return api::is_space(c) || is_digit(c); });
  return unit.empty() ||
         (begins(unit.front()) && word && !is_broken_exponent(unit) && find_control(unit) == std::string_view::npos &&
          unit.find('%') == std::string_view::npos && is_utf8(unit));
}

Error no_limit(std::string_view text) {
  const bool comma = text.find(',') != std::string_view::npos;
  return refused(
      "must be a number (0.05), a number and a unit (0.05 mm) or a share of the baseline's diagonal (0.5 %), " +
      ("not " + shown_text(text)) + (comma ? "; write the decimals behind a point" : ""));
}

}  // namespace

Result<Limit> parse_limit(std::string_view text) {
  const auto quantity = split(text);
  if (!quantity) return no_limit(text);
  const bool share = quantity->unit == "%";
  if (!share && !is_label(quantity->unit)) return no_limit(text);
  if (is_share(quantity->unit)) return refused("must have '%' for a share of the diagonal, not " + shown_text(text));
  if (!api::in_range(quantity->number, api::kMaxDistanceRange, "").ok()) {
    return refused("must be a finite number of at least 0, not " + shown_text(text));
  }
  if (quantity->unit.size() > api::kMaxUnitsBytes) {
    return refused("must have a unit of at most " + std::to_string(api::kMaxUnitsBytes) + " bytes, not " +
                   shown_text(quantity->unit));
  }
  Limit limit;
  if (share) return limit.max_diagonal_share = quantity->number / 100, limit;
  limit.max_distance = quantity->number;
  limit.units = quantity->unit;
  return limit;
}

Result<std::chrono::milliseconds> parse_duration(std::string_view text) {
  const auto quantity = split(text);
  const auto factor = [&]() -> std::optional<double> {
    if (!quantity) return std::nullopt;
    if (quantity->unit.empty() || quantity->unit == "s") return 1000;
    if (quantity->unit == "ms") return 1;
    return quantity->unit == "min" ? std::optional<double>(60'000) : std::nullopt;
  }();
  if (!factor) return refused("must be a time, as 60 s, 500 ms, 2 min or a number of seconds, not " + shown_text(text));
  const double milliseconds = std::nearbyint(quantity->number * *factor);
  if (const auto checked = api::in_range(milliseconds, api::kTimeoutMsRange, ""); !checked) {
    const auto most = static_cast<int>(api::kTimeoutMsRange.high / 1000);
    return refused("must be from 1 ms to " + std::to_string(most) + " s, not " + shown_text(text));
  }
  return std::chrono::milliseconds(static_cast<std::int64_t>(milliseconds));
}

}  // namespace meshgauge::check
