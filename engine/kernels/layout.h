// The data of the kernels: the nodes and leaves of engine/tree/bvh.h as plain arrays of numbers, with one entry for
// each lane.
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

// Eight prepared triangles (engine/tree/triangle.h). Lanes beyond the last triangle repeat it.
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

// What may lower a linear lower bound (engine/extras/area/minorant.h): what is near the centre and, in each of the
// directions, higher than its top.
struct LowerProbe {
  static constexpr std::size_t kMaxDirections = 8;
  double centre[3];
  double limit_sq;  // of the distance from the centre: far_limit()
  double n[kMaxDirections][3];
  double tops[kMaxDirections];
  std::size_t directions;
};

// Beyond every coordinate in a patch frame.
inline constexpr double kPatchNowhere = 8;

// Coordinates along three axes, orthonormal up to rounding, from an origin. The third axis is the direction of sight of
// the patch certificate (engine/fast/bounds/patch.h).
struct PatchFrame {
  double origin[3];
  double axes[3][3];
};

// Eight triangles in a patch frame, each with its plane z = level + slope_x * x + slope_y * y.
struct alignas(64) PatchBlock {
  double x[3][kLanes];  // by corner
  double y[3][kLanes];
  double z[3][kLanes];
  double slope_x[kLanes];
  double slope_y[kLanes];
  double level[kLanes];
  double error[kLanes];  // of a height computed from the plane: rounding.h R11
  double low_x[kLanes];  // the box of the image; empty if the lane is not used
  double high_x[kLanes];
  double low_y[kLanes];
  double high_y[kLanes];
};

// One triangle in a patch frame.
struct PatchPiece {
  double x[3];
  double y[3];
  double z[3];
  double slope_x;
  double slope_y;
  double level;
  double error;
  double low_x;
  double high_x;
  double low_y;
  double high_y;
  double inner_x;  // a point inside of the image
  double inner_y;
};

// The orientations of eight images. Bit i: of lane i.
struct Orientations {
  unsigned left;   // corners in counterclockwise order
  unsigned right;  // in clockwise order
};

// How the triangles of a block lie over a piece. Bit i: of lane i.
struct PatchCover {
  unsigned near;   // may meet the piece within the limit
  unsigned above;  // of those, without a bound within the limit
  unsigned inner;  // of those that are near, the ones which surely contain the piece's inner point
  double upper;    // the largest bound of those that are near and not above
};

}  // namespace meshgauge
