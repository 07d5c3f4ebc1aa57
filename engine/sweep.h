// The first phase of strategy `auto`: most triangles of A are culled without a query.
//
//  * A is cut into blocks of 64 triangles along a space-filling curve. One vertex of each is measured first: this
//  sparse
//    sample gives most of the final lower bound. Each block's box is bounded (eq. 4/5); the blocks are visited from the
//    largest bound down, and the first that is small enough ends the sweep.
//  * To cull a triangle any triangle T of B will do with max over corners d(v,T) <= lower + tolerance (eq. 9), not the
//    nearest. Tried are its twin (engine/twins.h), the one behind the one that served last, and those that neighbours
//    used.
//  * What they do not cull the overlay bound often does, without a query, once B's adjacency pays.
//  * A query starts from the distance to a triangle that a neighbour found: most of the tree is never entered.
#pragma once

#include <optional>

#include "engine/bounds/overlay.h"
#include "engine/ordered_mesh.h"
#include "engine/search.h"

namespace meshgauge {

// `from` and `to` are the search's meshes. Leaves in `search` the triangles of A that survive, each with its bounds.
// Returns the reason when it was stopped early; what it had not visited then stays accounted for in search.upper(). On
// all threads of the search's pool.
std::optional<Stop> sweep(Search& search, const OrderedMesh& from, const OrderedMesh& to);

}  // namespace meshgauge
