// Guesses at which triangle of B lies under a triangle of A: a mesh is often compared with a copy of itself that was
// moved, smoothed, rounded, cut or stirred. A wrong guess costs time, nothing else.
#pragma once

#include <cstdint>

#include "engine/large_array.h"
#include "engine/ordered_mesh.h"

namespace meshgauge {

inline constexpr std::uint32_t kNoTwin = ~std::uint32_t{0};

// For each triangle of `from` the one of `to` that had the same number in the caller's meshes, or kNoTwin. Empty if one
// mesh has more than twice as many triangles as the other: then they are hardly copies. Linear time.
LargeArray<std::uint32_t> twins_by_number(const OrderedMesh& from, const OrderedMesh& to);

// For each triangle of `from` one of `to` with corners at the same positions, in any order, or kNoTwin. Linear time.
// Empty when `interrupted` says to stop.
LargeArray<std::uint32_t> twins_by_position(const OrderedMesh& from, const OrderedMesh& to,
                                            const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
