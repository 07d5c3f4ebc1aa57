// The first phase of the paper's strategies (Algorithm 2; `auto` has sweep.h): goes through A's tree depth first and
// culls what cannot hold the maximum.
#pragma once

#include <optional>

#include "engine/search/search.h"

namespace meshgauge {

// Pushes the triangles of A that survive into `search`, each with its bound, and raises the lower bound at every vertex
// that it measures; it measures each vertex at most once. `from` is a tree over search.from().
// Returns nullopt: all of A is visited; else the reason to stop, and search.upper() still covers what was not visited.
std::optional<Stop> traverse(Search& search, const Bvh& from, PieceBound& bound);

}  // namespace meshgauge
