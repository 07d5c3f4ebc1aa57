// Distance between two triangles.
#pragma once

#include <array>

#include "engine/tree/triangle.h"

namespace meshgauge {

struct CornersAndFrame {
  std::array<Vec3, 3> corners;
  PreparedTriangle prepared;
};

// Returns d(S,T) of two triangles in the unit frame; 0 where they pierce, touch or overlap. Degenerate triangles are
// segments or points. The result is within some units of rounding of the true distance.
double triangle_distance(const CornersAndFrame& s, const CornersAndFrame& t);

}  // namespace meshgauge
