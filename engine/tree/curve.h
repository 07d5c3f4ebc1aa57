// Orders the triangles of a mesh along a space-filling curve, so that neighbours in the order are neighbours in space.
#pragma once

#include <cstdint>
#include <span>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/large_array.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Returns the `chosen` triangles (empty: all) in the order of their centres along a Hilbert curve through `box`, the
// box of the mesh, with 1024 cells on each axis. Triangles in one cell are ordered the same way within their own box,
// and so on. Deterministic, also with several threads. Linear time. Empty: interrupted.
LargeArray<std::uint32_t> curve_order(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& box,
                                      Control& control, ThreadPool& pool);

}  // namespace meshgauge
