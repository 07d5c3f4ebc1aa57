// The triangles of a mesh along a space-filling curve, so that neighbours in the order are neighbours in space.
#pragma once

#include <cstdint>
#include <span>

#include "engine/control.h"
#include "engine/large_array.h"
#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// The `chosen` triangles, or all if none are, by the place of their centres on a Hilbert curve through `box` (that of
// the mesh), 1024 cells an axis; what shares a cell is ordered the same way within its own box, and so on.
// Deterministic, whatever the pool. Linear time. Empty when `control` says to stop.
LargeArray<std::uint32_t> curve_order(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& box,
                                      Control& control, ThreadPool& pool);

}  // namespace meshgauge
