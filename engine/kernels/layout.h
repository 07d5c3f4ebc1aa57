// What the kernels read: the nodes and leaves of engine/bvh.h, as plain arrays of numbers with one entry a lane.
#pragma once

#include <cstddef>
#include <cstdint>

namespace meshgauge {

inline constexpr std::size_t kLanes = 8;  // children of a node, triangles of a block

// The boxes of up to eight children, as offsets from the node's own origin in single precision, widened so that
// rounding.h R6 holds. A child that is not there has an empty box, which no distance is below.
struct alignas(64) WideNode {
  static constexpr std::uint32_t kLeaf = 0x8000'0000U;  // this bit and the number of a block; else the number of a node
  static constexpr std::uint32_t kNone = 0xffff'ffffU;

  float low[3][kLanes];
  float high[3][kLanes];
  double origin[3];
  std::uint32_t child[kLanes];
  float reach;  // no coordinate below is farther from the origin, along an axis
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

// One of them.
struct FlatTriangle {
  double a[3];
  double e1[3];
  double e2[3];
  double length;
  double cx;
  double cy;
};

// Lengths below this are taken as zero, so that no square underflows; the measured residual accounts for it.
inline constexpr double kNegligibleLength = 0x1p-400;

// Points, a coordinate an array.
struct PointBlock {
  alignas(64) double at[3][kLanes];
};

}  // namespace meshgauge
