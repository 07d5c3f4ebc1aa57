// Joins vertices of equal position, for the formats that store three vertices a triangle.
#pragma once

#include <cstddef>

#include "engine/mesh.h"

namespace meshgauge::api {

// Vertices are equal when all three coordinates are (-0.0 equals 0.0, and becomes it). Keeps the order in which
// positions are first seen, and every triangle, also those that become degenerate. Returns how many vertices
// went. Precondition: indices in range, no NaN. Expected linear time whatever the positions; memory of two
// arrays of indices.
std::size_t weld(Mesh& mesh);

}  // namespace meshgauge::api
