// Distance between two triangles.
#pragma once

#include <array>

#include "engine/triangle.h"

namespace meshgauge {

struct CornersAndFrame {
  std::array<Vec3, 3> corners;
  PreparedTriangle prepared;
};

// d(S,T) for triangles in the unit frame, 0 where they meet: piercing, touching, coplanar overlap. Degenerate triangles
// are segments or points. Computed: within some units of rounding of the true distance.
double triangle_distance(const CornersAndFrame& s, const CornersAndFrame& t);

}  // namespace meshgauge
