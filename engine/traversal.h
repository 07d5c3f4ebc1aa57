// The traversal (paper, Algorithm 2): A's tree depth first, culling what cannot hold the maximum.
#pragma once

#include <optional>

#include "engine/search.h"

namespace meshgauge {

// `from` is a tree over search.from(). Leaves in `search` the triangles of A that survive, each with its bounds; raises
// its lower bound by every vertex it measures. Returns the reason when it was stopped early; what it had not visited
// then stays accounted for in search.upper(). Each vertex of A is measured at most once.
std::optional<Stop> traverse(Search& search, const Bvh& from, PieceBound& bound);

}  // namespace meshgauge
