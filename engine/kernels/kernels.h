// The inner loops of the engine, once for each instruction set, chosen by name.
//
// All of them do the same operations in the same order, lane by lane, and none is fused: every set gives the same bits,
// and the error bounds of engine/rounding.h hold for all. `scalar` is the reference, in plain C++.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "engine/kernels/layout.h"

namespace meshgauge {

// A tree for the eyes of a kernel. Node 0 is the root.
struct TreeView {
  const WideNode* nodes;
  const TriangleBlock* blocks;
};

// The closest triangle so far: number s is lane s % kLanes of block s / kLanes.
struct Closest {
  double distance_sq;
  std::uint32_t slot;
};

struct Kernels {
  const char* name;  // "scalar", "sse4", "avx2", "avx512", "neon"

  // Prepares eight triangles with the corners corners[0..2], as prepare() of engine/triangle.h does one, and returns
  // the largest distance between a prepared corner and the given one, computed (rounding.h R2).
  double (*prepare)(const PointBlock corners[3], TriangleBlock& out);

  // The triangle closest to p among those closer than `best`, or `best` itself. `tests` is raised by the number of
  // point-triangle distances computed. Every triangle that is closer than the result by more than rounding is found:
  // boxes are passed over only when rounding.h R6 says that they are farther.
  Closest (*nearest)(const TreeView& tree, const double p[3], Closest best, std::uint64_t& tests);

  // The largest squared distance of the points from the triangle in that lane (rounding.h R3). All lanes of `points`
  // hold one, but only the first half of them counts: the others repeat some of those.
  double (*farthest_sq)(const TriangleBlock& block, std::size_t lane, const PointBlock& points);
};

// What this processor can run, the fastest first; always ends with `scalar`. Constant after the first call; thread
// safe.
std::span<const Kernels> supported_kernels();

// The one with this name, or the fastest for "auto"; null if this processor cannot run it or there is none.
const Kernels* find_kernels(std::string_view name);

// How much of a tree's depth the stacks of the queries have room for.
inline constexpr std::size_t kMaxTreeDepth = 96;
inline constexpr std::size_t kMaxStack = kMaxTreeDepth * (kLanes - 1) + 2;

// From this many times a node's reach on its boxes are compared in double: far away, single precision cannot tell them
// apart.
inline constexpr float kFar = 32;

// A squared distance to a box, computed in single or in double precision, that is above this is of a box farther than
// sqrt(best_sq): rounding.h R6. Empty lanes have infinite distances, which are above every limit.
inline constexpr float kNoLimit = 0x1p126F;
inline float near_limit(double best_sq) {
  const double limit = best_sq * (1 + 0x1p-18) + 0x1p-100;
  return limit < kNoLimit ? static_cast<float>(limit) : kNoLimit;
}
inline double far_limit(double best_sq) {
  const double limit = best_sq * (1 + 0x1p-48) + 0x1p-1000;
  return limit < kNoLimit ? limit : static_cast<double>(kNoLimit);
}

}  // namespace meshgauge
