// Units of length, and the source of a mesh's unit.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace meshgauge::api {

enum class LengthUnit { micron, millimeter, centimeter, meter, inch, foot };

inline constexpr LengthUnit kLengthUnits[] = {LengthUnit::micron, LengthUnit::millimeter, LengthUnit::centimeter,
                                              LengthUnit::meter,  LengthUnit::inch,       LengthUnit::foot};

std::string_view to_string(LengthUnit unit);  // "um", "mm", "cm", "m", "in", "ft"
std::string unit_names();                     // "um, mm, cm, m, in, ft"

// Empty: not known.
inline std::string_view to_string(const std::optional<LengthUnit>& unit) {
  return unit ? to_string(*unit) : std::string_view();
}

// The source of a mesh's unit.
enum class UnitSource {
  unknown,   // the format has no unit, and none was declared
  file,      // the file names it (3MF), or its format fixes it (glTF: metres)
  declared,  // by the request, the manifest or a flag
  assumed,   // the limit's unit, assumed for two meshes of unknown unit
};

std::string_view to_string(UnitSource source);

}  // namespace meshgauge::api
