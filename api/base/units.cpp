#include "api/base/units.h"

#include <cstddef>

namespace meshgauge::api {

std::string_view to_string(LengthUnit unit) {
  constexpr std::string_view kNames[] = {"um", "mm", "cm", "m", "in", "ft"};
  return kNames[static_cast<std::size_t>(unit)];
}

std::string unit_names() {
  std::string names;
  for (const LengthUnit unit : kLengthUnits) names.append(names.empty() ? "" : ", ").append(to_string(unit));
  return names;
}

std::string_view to_string(UnitSource source) {
  constexpr std::string_view kNames[] = {"unknown", "file", "declared", "assumed"};
  return kNames[static_cast<std::size_t>(source)];
}

}  // namespace meshgauge::api
