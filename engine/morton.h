// An order of triangles in which neighbours in the list are mostly neighbours in space.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/mesh.h"

namespace meshgauge {

// The indices of the mesh's triangles along a Morton (Z-order) curve through their centroids. Unit frame; `box` is the
// mesh's. Linear time.
std::vector<std::uint32_t> morton_order(MeshView mesh, const Box& box);

}  // namespace meshgauge
