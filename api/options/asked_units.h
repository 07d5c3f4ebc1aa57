// Units of length in a request: their spellings, and what a request declares.
#pragma once

#include <optional>
#include <string_view>

#include "api/base/units.h"

namespace meshgauge::api {

// Parses the usual spellings of a unit, ASCII letters in either case: "mm", "millimeter", "Millimetres", "\"", "µm".
// nullopt: not a unit.
std::optional<LengthUnit> parse_unit(std::string_view text);

std::string_view in_words(LengthUnit unit);  // "millimetres", for sentences

// Given as a limit's unit: the unit of mesh b (AskedUnits::limit_of_b).
inline constexpr std::string_view kUnitOfB = "b";

// Given as a limit's unit: the diagonal of mesh b's bounding box (AskedUnits::limit_of_diagonal).
inline constexpr std::string_view kUnitOfDiagonal = "diagonal";

// The units that a request declares.
struct AskedUnits {
  std::optional<LengthUnit> a;      // overrides the file's unit; nullopt: not declared
  std::optional<LengthUnit> b;      // overrides the file's unit; nullopt: not declared
  std::optional<LengthUnit> limit;  // of the limits and of lengths beside them; nullopt: without unit, or none
  bool limit_of_b = false;          // true: the limit is in the unit of mesh b, known or not
  bool limit_of_diagonal = false;   // true: limits are fractions of the diagonal of mesh b's bounding box

  bool operator==(const AskedUnits&) const = default;
};

// Returns the limit's unit as a request names it: a unit, kUnitOfB or kUnitOfDiagonal; empty: none.
std::string_view limit_unit_name(const AskedUnits& asked);

}  // namespace meshgauge::api
