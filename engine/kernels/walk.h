// The leaves of a tree in the order of their distance, in plain C++.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/kernels/kernels.h"

namespace meshgauge {

struct WalkEntry {
  float distance_sq;
  std::uint32_t child;
};

inline float box_distance_sq(const WideNode& node, std::size_t lane, const std::array<float, 3>& p) {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const float gap = std::max(std::max(node.low[k][lane] - p[k], p[k] - node.high[k][lane]), 0.0F);
    sum += gap * gap;
  }
  return sum;
}

// Lays the children within `limit` on the stack: in the order of their lanes, but for the nearest, which changes places
// with the last.
inline std::size_t push_children(const WideNode& node, const std::array<float, 3>& p, float limit, WalkEntry* stack,
                                 std::size_t size) {
  std::size_t nearest = size;
  const std::size_t bottom = size;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const WalkEntry entry{box_distance_sq(node, lane, p), node.child[lane]};
    if (!(entry.distance_sq <= limit)) continue;
    if (size > bottom && entry.distance_sq < stack[nearest].distance_sq) nearest = size;
    stack[size++] = entry;
  }
  if (size > bottom) std::swap(stack[nearest], stack[size - 1]);
  return size;
}

// Depth first, the nearest child first. `visit(block)` returns the squared distance beyond which nothing is of interest
// any more; what is passed over is farther than that (rounding.h R6). Ends when it is 0.
template <class Visit>
void walk(const TreeView& tree, const double p[3], double limit_sq, Visit&& visit) {
  std::array<WalkEntry, kMaxStack> stack;
  std::size_t size = 0;
  stack[size++] = {0, 0};
  float limit = box_limit(limit_sq);
  while (size > 0) {
    const WalkEntry entry = stack[--size];
    if (entry.distance_sq > limit) continue;
    if (entry.child & WideNode::kLeaf) {
      limit_sq = visit(entry.child & ~WideNode::kLeaf);
      if (limit_sq == 0) return;
      limit = box_limit(limit_sq);
    } else {
      const WideNode& node = tree.nodes[entry.child];
      std::array<float, 3> local;
      for (std::size_t k = 0; k < 3; ++k) local[k] = static_cast<float>(p[k] - node.origin[k]);
      size = push_children(node, local, limit, stack.data(), size);
    }
  }
}

}  // namespace meshgauge
