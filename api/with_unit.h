// Formats a length with its unit.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "api/units.h"

namespace meshgauge::api {

// Returns "0.05 mm" or "(1, 2, 3) mm"; the number alone when the unit is unknown (empty).
inline std::string with_unit(std::string number, std::string_view unit) {
  if (!unit.empty()) number.append(" ").append(unit);
  return number;
}

inline std::string with_unit(std::string number, const std::optional<LengthUnit>& unit) {
  return with_unit(std::move(number), unit ? to_string(*unit) : std::string_view());
}

}  // namespace meshgauge::api
