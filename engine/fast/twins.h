// Finds the triangle of B that corresponds to a triangle of A: a mesh is often compared with a copy of itself that was
// moved, smoothed, rounded, cut or reordered.
#pragma once

#include <cstdint>

#include "engine/control.h"
#include "engine/mesh/large_array.h"
#include "engine/tree/ordered_mesh.h"
#include "engine/tree/prepared.h"

namespace meshgauge {

inline constexpr std::uint32_t kNoTwin = ~std::uint32_t{0};

// Returns a guess: for each triangle of `from` the triangle of `to` with the same number in the given meshes, or
// kNoTwin. Empty: one of the given meshes has more than twice as many triangles as the other, so they are hardly
// copies; or `from` is so small a part that finding its twins takes longer than doing without. Linear time.
LargeArray<std::uint32_t> twins_by_number(const OrderedMesh& from, const OrderedMesh& to);

// Returns for each triangle of `from` a triangle of `to` with the same three corners, in any order, or kNoTwin. Unlike
// twins_by_number() this is no guess: all points of a triangle with a twin are at distance 0 from `to`, exactly. If
// most of a sample have their twin under their own number, only such twins are looked for. Empty: less than half of a
// sample of `from` is in `to`, or interrupted. Linear time. The result does not depend on to.use().
LargeArray<std::uint32_t> shared_triangles(MeshView from, const Prepared& to, const Interrupted& interrupted);

}  // namespace meshgauge
