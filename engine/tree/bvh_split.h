// Splits the leaves of a tree into nodes: engine/tree/bvh.h.
#pragma once

#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/kernels/layout.h"
#include "engine/mesh.h"
#include "engine/mesh/large_array.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Returns the nodes over leaves with these boxes, by the surface area heuristic from the top down. Node 0 is the root,
// parents come before their children, no path is longer than kMaxTreeDepth. Only child[lane] is set, not the boxes. The
// result does not depend on the pool. Empty: interrupted.
LargeArray<WideNode> split_wide(std::span<const Box> leaves, Control& control, ThreadPool& pool);

}  // namespace meshgauge
