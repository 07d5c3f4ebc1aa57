// The one way to write a length with its unit.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "api/units.h"

namespace meshgauge::api {

// "0.05 mm", "(1, 2, 3) mm"; the number alone where the unit is not known (empty).
inline std::string with_unit(std::string number, std::string_view unit) {
  if (!unit.empty()) number.append(" ").append(unit);
  return number;
}

inline std::string with_unit(std::string number, const std::optional<LengthUnit>& unit) {
  return with_unit(std::move(number), unit ? to_string(*unit) : std::string_view());
}

}  // namespace meshgauge::api
