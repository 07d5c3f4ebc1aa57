// Merges vertices of equal position, for formats that store three vertices for each triangle.
#pragma once

#include <cstddef>

#include "engine/mesh.h"

namespace meshgauge::api {

// Merges vertices whose three coordinates are equal (-0.0 equals 0.0 and becomes 0.0). Keeps the order in which
// positions first occur, and every triangle, also those that become degenerate. Returns the number of vertices removed.
// Precondition: indices in range, no NaN. Expected linear time for any positions; allocates two arrays of indices.
std::size_t weld(Mesh& mesh);

}  // namespace meshgauge::api
