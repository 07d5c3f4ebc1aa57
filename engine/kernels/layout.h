// The data of the kernels: the nodes and leaves of engine/bvh.h as plain arrays of numbers, with one entry for each
// lane.
#pragma once

#include <cstddef>
#include <cstdint>

namespace meshgauge {

inline constexpr std::size_t kLanes = 8;  // children of a node, triangles of a block

// The boxes of up to eight children, as offsets from the node's own origin in single precision, widened so that
// rounding.h R6 holds. A missing child has an empty box, at infinite distance.
struct alignas(64) WideNode {
  static constexpr std::uint32_t kLeaf = 0x8000'0000U;  // set: the other bits number a block; else a node
  static constexpr std::uint32_t kNone = 0xffff'ffffU;

  float low[3][kLanes];
  float high[3][kLanes];
  double origin[3];
  std::uint32_t child[kLanes];
  float reach;  // largest distance of a coordinate below from the origin, on one axis
};

// Eight prepared triangles (engine/triangle.h). Lanes beyond the last triangle repeat it.
struct alignas(64) TriangleBlock {
  double a[3][kLanes];
  double e1[3][kLanes];
  double e2[3][kLanes];
  double length[kLanes];
  double cx[kLanes];
  double cy[kLanes];
};

// One prepared triangle.
struct FlatTriangle {
  double a[3];
  double e1[3];
  double e2[3];
  double length;
  double cx;
  double cy;
};

// Shorter lengths count as zero, so that no square underflows; the measured residual accounts for it.
inline constexpr double kNegligibleLength = 0x1p-400;

// Points: one array for each coordinate.
struct PointBlock {
  alignas(64) double at[3][kLanes];
};

}  // namespace meshgauge
