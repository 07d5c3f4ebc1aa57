// A line before the points of an XYZ that names its columns.
#pragma once

#include <string_view>

namespace meshgauge::api {

enum class XyzHeading {
  none,           // no heading: a point, a comment, a mistake
  x_y_z,          // "//X Y Z Rf Gf Bf", as CloudCompare writes it, "X Y Z" or "# X Y Z": as the points are read
  other_columns,  // "//R G B X Y Z", "# Z Y X", "// anything else": the points may be others than the first columns
};

// Takes one line without its end. Linear time.
XyzHeading xyz_heading(std::string_view line);

}  // namespace meshgauge::api
