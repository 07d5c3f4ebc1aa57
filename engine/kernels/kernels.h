// The inner loops of the engine, compiled once for each instruction set and chosen by name.
//
// All of them do the same operations in the same order, lane by lane, and none is fused: every set gives the same bits,
// and the error bounds of engine/rounding.h hold for all. `scalar` is the reference, in plain C++.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/control.h"
#include "engine/kernels/layout.h"
#include "engine/rounding.h"

namespace meshgauge {

// The arrays of a tree. Node 0 is the root.
struct TreeView {
  const WideNode* nodes;
  const TriangleBlock* blocks;
};

// The closest triangle found so far.
struct Closest {
  double distance_sq;
  std::uint32_t slot;  // lane slot % kLanes of block slot / kLanes
};

// The point-triangle distances between two polls of whether to stop: some 0.1 ms of work.
inline constexpr std::uint64_t kTestsBetweenPolls = 1 << 14;

// Whether one query, which may test every triangle, ends early. Not thread safe.
class Polling {
 public:
  Polling() = default;  // it ends only at a triangle that holds the point
  // `tests`: the count of distances when the query begins. Borrows `stop`; null: never. `enough_sq`: the squared
  // distance at which a triangle is near enough.
  Polling(const Interrupted* stop, std::uint64_t tests, double enough_sq = 0) : stop_(stop), enough_sq_(enough_sq) {
    if (stop) next_ = tests + kTestsBetweenPolls;
  }

  // Whether to end now, after `tests` distances, the least of which is this.
  bool poll(std::uint64_t tests, double least_sq) { return least_sq <= enough_sq_ || poll(tests); }
  // The same, whatever the distances are.
  bool poll(std::uint64_t tests) {
    if (tests < next_) return false;
    next_ = tests + kTestsBetweenPolls;
    return stopped_ = (*stop_)();
  }
  bool stopped() const { return stopped_; }

 private:
  const Interrupted* stop_ = nullptr;
  double enough_sq_ = 0;
  std::uint64_t next_ = ~std::uint64_t{0};
  bool stopped_ = false;
};

struct Kernels {
  const char* name;  // "scalar", "sse4", "avx2", "avx512", "neon"

  // Prepares eight triangles with the corners corners[0..2], each as prepare() of engine/tree/triangle.h does. Returns
  // the largest computed distance between a prepared corner and the given one (rounding.h R2).
  double (*prepare)(const PointBlock corners[3], TriangleBlock& out);

  // Returns the triangle closest to p among those closer than `best`, or `best` itself. No triangle is closer than the
  // result by more than rounding: a box is skipped only if it is farther by rounding.h R6. Adds the number of computed
  // point-triangle distances to `tests`. When `polling` ends it, the result is the closest triangle so far.
  Closest (*nearest)(const TreeView& tree, const double p[3], Closest best, std::uint64_t& tests, Polling& polling);

  // Returns the largest squared distance of the points from the triangle in that lane (rounding.h R3). Only the first
  // kLanes / 2 points count; the other lanes must repeat some of them.
  double (*farthest_sq)(const TriangleBlock& block, std::size_t lane, const PointBlock& points);

  // Projects the triangles with the corners corners[0..2] for the patch certificate. Uses the lanes whose images are
  // surely in counterclockwise order and not too thin: `left` of the result. `right`: the same in clockwise order.
  Orientations (*project)(const PointBlock corners[3], const PatchFrame& frame, PatchBlock& out);

  // Bounds the difference of height between the piece and each triangle of the block over their common part. The bits
  // err to the safe side: rounding.h R11.
  PatchCover (*cover)(const PatchBlock& block, const PatchPiece& piece, double limit);

  // Returns the boxes, or the triangles with the corners corners[0..2], that may lower a bound. Bit i: of lane i. The
  // squared distances are those of the boxes from the centre. Rounding: R12.
  unsigned (*lower_boxes)(const PointBlock& low, const PointBlock& high, const LowerProbe& probe,
                          double distances_sq[kLanes]);
  unsigned (*lower_triangles)(const PointBlock corners[3], const LowerProbe& probe);
};

// The kernels that this processor can run, the fastest first, `scalar` last. Constant; thread safe.
std::span<const Kernels> supported_kernels();

Kernels scalar_kernels();             // the reference, in plain C++
std::vector<Kernels> simd_kernels();  // those of this processor, the fastest first; empty: Highway does not support it

// Returns the kernels with this name, or the fastest for "auto". nullptr: unknown or not supported by this processor.
const Kernels* find_kernels(std::string_view name);

// The depth of a tree, in nodes, that the stacks of queries have room for.
inline constexpr std::size_t kMaxTreeDepth = 96;
inline constexpr std::size_t kMaxStack = kMaxTreeDepth * (kLanes - 1) + 2;

// If p is farther from a node's origin than this many times its reach, on an axis, its boxes are compared in double:
// single precision cannot tell them apart.
inline constexpr float kFar = 32;

// A box whose squared distance, computed in single or in double precision, is above this limit is farther than
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
