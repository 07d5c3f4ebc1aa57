// How the leaves of a tree are gathered into nodes: engine/bvh.h.
#pragma once

#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/kernels/layout.h"
#include "engine/large_array.h"
#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Nodes over leaves with these boxes, with children but without boxes: child[lane] is set, the rest is not. Parents
// come before their children, node 0 is the root, no path is longer than kMaxTreeDepth. By the surface area heuristic,
// from the top down. The same whatever the pool. Empty when `control` says to stop.
LargeArray<WideNode> split_wide(std::span<const Box> leaves, Control& control, ThreadPool& pool);

}  // namespace meshgauge
