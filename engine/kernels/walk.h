// Visits the leaves of a tree, near ones first, in plain C++.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "engine/kernels/kernels.h"

namespace meshgauge {

// A child on the stack of a walk.
struct WalkEntry {
  float distance_sq;
  std::uint32_t child;
};

// The squared distance of p, given as an offset from the node's origin, from a child's box.
template <class Number>
Number box_distance_sq(const WideNode& node, std::size_t lane, const std::array<Number, 3>& p) {
  Number sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Number low = node.low[k][lane], high = node.high[k][lane];
    const Number gap = std::max(std::max(low - p[k], p[k] - high), Number{0});
    sum += gap * gap;
  }
  return sum;
}

// Pushes the children within `limit` in the order of their lanes, then swaps the nearest to the top. Returns the new
// size of the stack.
template <class Number>
std::size_t push_within(const WideNode& node, const std::array<Number, 3>& p, Number limit, WalkEntry* stack,
                        std::size_t size) {
  const std::size_t bottom = size;
  std::size_t nearest = size;
  Number least = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const Number distance_sq = box_distance_sq(node, lane, p);
    if (!(distance_sq <= limit)) continue;
    if (size == bottom || distance_sq < least) least = distance_sq, nearest = size;
    stack[size++] = {static_cast<float>(distance_sq), node.child[lane]};
  }
  if (size > bottom) std::swap(stack[nearest], stack[size - 1]);
  return size;
}

// Pushes the children that may be closer than sqrt(best_sq). Returns the new size of the stack.
inline std::size_t push_children(const WideNode& node, const double p[3], double best_sq, WalkEntry* stack,
                                 std::size_t size) {
  std::array<double, 3> local;
  std::array<float, 3> local_float;
  bool far = false;
  for (std::size_t k = 0; k < 3; ++k) {
    local[k] = p[k] - node.origin[k];
    local_float[k] = static_cast<float>(local[k]);
    far = far || std::abs(local_float[k]) > kFar * node.reach;
  }
  if (far) return push_within(node, local, far_limit(best_sq), stack, size);
  return push_within(node, local_float, near_limit(best_sq), stack, size);
}

inline constexpr double kEndWalk = 0;

// Calls visit(block) for the blocks that may be closer to p than sqrt(best_sq), depth first, the nearest child first.
// visit() returns the new best_sq; the walk skips boxes that are farther and ends at kEndWalk.
template <class Visit>
void walk(const TreeView& tree, const double p[3], double best_sq, Visit&& visit) {
  std::array<WalkEntry, kMaxStack> stack;
  std::size_t size = 0;
  stack[size++] = {0, 0};
  while (size > 0) {
    const WalkEntry entry = stack[--size];
    if (entry.distance_sq > near_limit(best_sq)) continue;
    if (entry.child & WideNode::kLeaf) {
      best_sq = visit(entry.child & ~WideNode::kLeaf);
      if (best_sq == kEndWalk) return;
    } else {
      size = push_children(tree.nodes[entry.child], p, best_sq, stack.data(), size);
    }
  }
}

}  // namespace meshgauge
