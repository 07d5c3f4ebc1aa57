// The first phase of strategy `auto`. It culls most triangles of A without a query:
//
//  1. It divides A into blocks of 64 triangles along a space-filling curve and measures one vertex of each block. This
//     sample gives most of the final lower bound.
//
//  2. It bounds the box of each block (eq. 4/5) and visits the blocks by descending bound. The first block whose bound
//     is within the tolerance ends the sweep: that bound covers all blocks which are left, and goes into upper().
//
//  3. Any triangle T of B with max over corners d(v,T) <= lower + tolerance culls a triangle of A (eq. 9); T need not
//     be the nearest. The candidates are the triangle's twin (engine/fast/twins.h), the successor in B's order of the
//     triangle used last, and the triangles that culled its neighbours.
//
//  4. If none of them does, the overlay bound often culls the triangle without a query, once there are enough such
//     triangles to pay for B's adjacency.
//
//  5. Otherwise it queries the corners' nearest triangles. A query starts from a triangle that a neighbour found, which
//     saves entering most of the tree.
#pragma once

#include <optional>

#include "engine/search/search.h"
#include "engine/tree/ordered_mesh.h"

namespace meshgauge {

// Pushes the triangles of A that survive into `search`, each with its bound. `from` and `to` are the search's meshes.
// Returns nullopt: all of A is visited; else the reason to stop, and search.upper() still covers what was not visited.
// Uses all threads of the search's pool.
std::optional<Stop> sweep(Search& search, const OrderedMesh& from, const OrderedMesh& to);

}  // namespace meshgauge
