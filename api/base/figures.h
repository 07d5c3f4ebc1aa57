// Writes numbers as text: exactly, for files and reports; for people with few digits, and never a statement that the
// interval contradicts; and a length with its unit.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "api/base/units.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// Returns the shortest decimal text that reads back as the same number.
inline std::string shortest(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

// Returns "0.05 mm" or "(1, 2, 3) mm"; the number alone when the unit is unknown (empty).
inline std::string with_unit(std::string number, std::string_view unit) {
  if (!unit.empty()) number.append(" ").append(unit);
  return number;
}

inline std::string with_unit(std::string number, const std::optional<LengthUnit>& unit) {
  return with_unit(std::move(number), to_string(unit));
}

// Returns " ± 0.01 mm" with up to six digits; empty for 0.
std::string plus_minus(double length, std::string_view unit);

// Formats x with up to `digits` significant digits, 1 to 17, without trailing zeros: "0.00012", "150000", "1.5e-12".
std::string to_digits(double x, int digits);
std::string to_digits_below(double x, int digits);  // rounded down: the printed number is at most x
std::string to_digits_above(double x, int digits);  // rounded up: the printed number is at least x

struct IntervalText {
  std::string lower;  // rounded down
  std::string upper;  // not below upper; "unknown" where it is infinite
  std::string limit;

  std::string both() const { return lower == upper ? lower : lower + " \xE2\x80\xA6 " + upper; }  // "1.2 … 1.3"
};

// Formats the bounds with as few digits as tell them apart, up to six, and with enough that each stays on its side of
// the limit, which is infinite where there is none.
IntervalText to_text(double lower, double upper, double limit);

std::string grouped(std::uint64_t count);   // "1,234,567"
std::string in_bytes(std::uint64_t bytes);  // "1.4 MB"
std::string in_time(double ms);             // "1.4 s"

// Returns "(1, 2.5, 3)": seven digits of the largest coordinate, so that 5.55e-17 beside 12.5 is 0, and at least four
// decimals, so that points far from the origin stay apart.
std::string in_words(const Vec3& point);

// Returns "4 open edges, the first at (0.5, 0, 1) mm" for the kind "open". `unit` may be empty.
std::string edges_in_words(std::uint64_t count, std::string_view kind, const Vec3& first, std::string_view unit);

}  // namespace meshgauge::api
