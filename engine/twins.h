// Which triangle of B lies under a triangle of A: a mesh is often compared with a copy of itself that was moved,
// smoothed, rounded, cut or stirred.
#pragma once

#include <cstdint>

#include "engine/control.h"
#include "engine/large_array.h"
#include "engine/ordered_mesh.h"
#include "engine/prepared.h"

namespace meshgauge {

inline constexpr std::uint32_t kNoTwin = ~std::uint32_t{0};

// A guess: for each triangle of `from` the one of `to` that had the same number in the caller's meshes, or kNoTwin.
// `to` is of all its triangles. Empty if one of the caller's meshes has more than twice as many triangles as the other:
// then they are hardly copies. Linear time.
LargeArray<std::uint32_t> twins_by_number(const OrderedMesh& from, const OrderedMesh& to);

// No guess: for each triangle of `from` one of `to` with the same three corners, in any order, or kNoTwin. All its
// points are at distance 0 from `to`, exactly. Where numbers agree, only twins of the same number are looked for.
// Empty if a sample of `from` shows that less than half of it is in `to`, or when `interrupted` says to stop. Linear
// time; next to none if the sample is not in `to`. The same whatever the use of `to`.
LargeArray<std::uint32_t> shared_triangles(MeshView from, const Prepared& to, const Interrupted& interrupted);

}  // namespace meshgauge
