// All error bounds and all outward rounding of the engine. Every certified number gets its slack from here; each
// constant is derived below, and docs/design.md follows the same steps.
//
// Setting. All computing happens in the unit frame of engine/mesh/frame.h: every coordinate of both meshes is at most 1
// in magnitude, so two points are at most 2*sqrt(3) < 3.47 apart. u = 2^-53: each operation of IEEE double arithmetic,
// rounded to nearest, returns x(1+d) with |d| <= u, or errs by at most 2^-1075 where the result is subnormal. (d1..dk
// multiply to 1+t with |t| <= k*u + O(u^2); the O(u^2) is far below the room that rounding each constant up to an
// integer leaves.)
//
// (R1) Length. |p-q| from the rounded differences of stored p and q: 3 factors for each square, 2 for the sum,
//      halved by the root, 1 for the root: (1+t), |t| <= 3.5u. Squares below 2^-1022 may lose 3 * 2^-1075, which
//      the root turns into less than 2^-536. In all at most 3.5u * 3.47 + 2^-536 < 13u.
//
// (R2) Closest point. closest_point() (engine/tree/triangle.h) picks (x,y) in the triangle's plane frame and returns
//      q = a + x*e1 + y*e2.
//      Forming q: rounding of x*e1 (|x| <= 3.47), y*e2 (|y| <= 3.01, the height of a triangle over its longest
//      edge), and two sums of points whose coordinates stay below 1.01 (error u*1.01*sqrt(3) each):
//      u * (3.47 + 3.01 + 3.5) < 10u.
//      (x,y) against the flat triangle F = (0,0), (length,0), (cx,cy): exact on the base; on a side, at most
//      3 roundings of numbers <= 3.47: < 11u. Inside, each of the two side tests is off by at most
//      2u(|x|+|y|) < 14u of distance to the side's line; the angle at c is the largest, at least 60 degrees, so the
//      point is within 14u / sin 30 = 28u of F. (At a and b the sharp angles do no harm: the base test y <= 0 is
//      exact, and with y > 0 and x < 0 or x > length a side test has no cancellation.)
//      F against the true triangle T: the map (x,y) -> a + x*e1 + y*e2 is affine, so the image of F is within
//      max(|a + length*e1 - b|, |a + cx*e1 + cy*e2 - c|) of T. That maximum is not estimated but measured when the
//      triangle is prepared: the residual, with the 10u + 6u of measuring it (kResidualSlack).
//      So q is within 38u + residual of T.
//
// (R3) Distance from above. d(p,T) <= fl|p-q| + (13 + 38)u + residual: kDistanceSlack = 64u.
//      This holds for whatever q the code chose: a poor choice makes the bound wide, never wrong.
//      The kernels measure from a: fl|(p-a) - (x*e1 + y*e2)|. Rounding: p-a and the last difference 3.47u each, x*e1
//      and y*e2 as in R2, their sum 3.47u, and 2.5u * 3.47 for the length: in all less than 26u instead of 10u + 13u,
//      and (26 + 28)u < 64u.
//
// (R4) Subdivision. A midpoint fl((a+b)/2) is within u per coordinate of the midpoint of the rounded a and b, < 2u as
//      a vector. After k levels a rounded corner is within 2u*k of the corner of the exact piece. d(.,T) is convex
//      and 1-Lipschitz, so an upper bound taken at rounded corners needs 2u*k more: kMidpointSlack a level.
//
// (R5) Distance from below. For any vector n != 0 and any triangle T, d(w,T) >= min over corners v of (w-v).n / |n|
//      (the plane through the lowest corner separates). Rounding of a dot product of three terms with rounded
//      differences: 4u * |w-v| |n| <= 14u |n|. With | |n| - 1 | <= 4u, leaving out the division costs
//      4u * 3.47 < 14u. kSeparationSlack = 32u.
//
// (R6) Boxes. A tree's node holds its children's boxes as offsets from an origin o, in float, rounded outwards
//      and wider by pad_k = 2^-22 E_k on axis k, E_k the largest |offset|. With t_k >= 0 the distance of p_k to the
//      child's true interval, |p_k - o_k| <= t_k + E_k.
//      Near: a query takes s_k = float(p_k - o_k), which errs by at most 2^-23.9 (t_k + E_k) + 2^-149; so the gap to
//      the stored interval, max(low - s_k, s_k - high, 0), is computed as at most
//      (t_k (1 + 2^-23.9) + 2^-149)(1 + 2^-24). Squared and summed in single precision: at most
//      d^2 (1 + 2^-21) + 2^-140, d the true distance of p to the box. So if the computed square is above
//      best^2 (1 + 2^-18) + 2^-100, that sum itself rounded to single precision, the box is farther than `best`.
//      Far (single precision cannot tell such boxes apart): the same in double. s_k = p_k - o_k errs by
//      u (t_k + E_k), far less than the pad covers; the rest is at most 12 roundings and underflows of 2^-1074, so
//      that the limit is best^2 (1 + 2^-48) + 2^-1000. Rounded to single precision, such a square may be compared
//      with the near limit, too. (engine/kernels/kernels.h: near_limit, far_limit.)
//
// (R7) Overlay. Derived where it is used, in engine/fast/bounds/overlay.h: kOverlayOffset = kOverlaySlack = 128u,
//      kOverlayBaseSlack = 512u.
//
// (R8) Conversion to another unit. Lengths are in the new unit, not in the frame. z = fl(fl(x * p) / q) for whole p
//      and q, which are exact.
//      Both operations err by at most u relatively, or by 2^-1075 where the result is subnormal:
//      |z - xp/q| <= (2u + u^2) |xp/q| + 2^-1075 (1 + (1 + u)/q) <= 2u (1 + 4u) |z| + 2^-1074 (1 + 4u).
//      As a vector, with |z| at most `largest` on each axis: sqrt(3) times that, below 4u * largest + 2^-1073.
//      scaling_error() adds room for its own roundings: 6u * largest + 2^-1072. A point of a triangle is a convex
//      combination of corners and moves no farther than they do, so both surfaces are within the error of each other,
//      and h(A,B) of the exact images is within error(A) + error(B) of h of the rounded ones.
//
// (R9) Usual residual. With R1 and products of at most 3.47: |a + length*e1 - b| is at most 3.5u * 3.47 for the length,
//      u * 3.47 each for b - a, for the division and for the product, and 2u for the sum: below 25u. At c the foot and
//      the vector across are each found with two dot products (4u * 3.47 each) and two differences of vectors, and
//      clamping the foot moves it by no more than its error: below 200u. kUsualResidual = 512u is an estimate made
//      before a residual is measured (engine/fast/front.h); no bound depends on it.
//
// (R10) Owner cut. Derived where it is used, in engine/fast/bounds/owner_cut.h: kCutSlack = 48u.
//
// (R11) Patch. A patch frame (engine/fast/bounds/patch.h) has an origin o in the unit frame and axes that are
// orthonormal up
//      to rounding. A vertex v is mapped to v' = fl(axes * (v - o)): |v - o| < 3.47, so |v'| < 4. The rounded v' are
//      taken as exact; what follows errs against them alone.
//
//      Frame: a coordinate of v' errs by 4u * 3.47, v' as a vector by less than 25u. A product of two axes errs by at
//      most 18u (one by itself) or 4u, so a length changes by the factor 1 +- 16u at most. A distance d < 3.47 in the
//      frame is one of less than d + 2 * 25u + 17u * 3.47 < d + 110u in the unit frame: kPatchSlack = 128u.
//
//      Plane: let E be the largest coordinate of the edges from the first corner, D twice the area of the image, and
//      q = E^2 / D, at least 1/2. An image is used only if q < 2^10, computed (kPatchThinnest), and E^2 > 2^-200
//      (kPatchSmallest). Each of D and the numerators of the slopes errs by 8u E^2. So the sign of D is right, and a
//      slope s errs by 8u q (1 + |s|) + u |s| <= 11u q (1 + |s|). With S = max |slope| and coordinates below 4, the
//      height level + slope_x x + slope_y y errs by 2 * 8 * 11u q (1+S) through its slopes (the plane passes through a
//      corner, at most 8 away on each axis), and by 48u (1+S) through the roundings of the level and of the sum: less
//      than 272u q (1+S). Over a box of half-widths below 4 slopes add 88u q (1+S), and roundings 96u q (1+S). A corner
//      of a clipped polygon is off by 36u (overlay.h), which changes the height by at most 204u q (1+S). The difference
//      of two heights and the sum of two errors add 64u q (1+S). In all less than 1024u q (1+S): kPatchHeightError, for
//      each of the two triangles.
//
//      Sides: as in the overlay (R7), a comparison with a line errs by less than 32u times |dx| + |dy| of the edge:
//      kPatchOffset = 128u.
//
//      Inner point: its weights are at least 1/4. With w the width of the image's box, w/2 <= E and no edge is longer
//      than sqrt(2) w. So it is D / (4 sqrt(2) w) > w / 2^15 inside each side, and it errs by less than 32u: it is
//      inside if w > 2^-30 (kPatchNarrowest).
//
// (R12) Enclosures (engine/area). A height p.n errs by 3u for its products and sums times |p||n| <= sqrt(3), less than
//      7u; the top of a triangle or box likewise, and by 2u more for the corners of a box, which are offsets from an
//      origin; their difference by 3.5u; |n| - 1 <= 4u costs 14u as in R5. Less than 35u. The constant of a box: R6
//      holds for the centre's distance, and the radius has kDistanceSlack for the 13u of R1 and 4u of the box's
//      corners. kMinorantSlack = 64u. An upper function is R3 and R4 at each corner; the radius of lipschitz.h
//      likewise. The value of a part's function at a cut is a difference of values below 4, times s <= 1, and a sum:
//      less than 8u + 8u + 8u, kCutValueSlack = 32u. The cut's point itself: a difference below 2 on each axis, times
//      s, and a sum: less than 5u an axis, 9u as a vector, for each level of cuts: kCutPointSlack = 16u instead of the
//      2u of R4. A weight is multiplied by s or fl(1 - s): 2u for each level. A share is a quotient of differences of
//      stored numbers, each with a relative error of u: two quotients of 3u and their product, 7u in all. kShareSlack =
//      32u also covers the roundings of the final quotient. A mean of high has a relative error of 4u, a mean square of
//      8u: kMeanSlack = 32u, with the final quotient. A sum of n terms >= 0, in any order, has a relative error of at
//      most n u (1 + n u): sum_error().
//
// (R13) Areas. Twice the area of a triangle is |x * y|, x and y two edges from one corner. A difference has a relative
//      error of u; a component of the product errs by 4u (|x1 y2| + |x2 y1|) <= 4u |x||y|, the vector by less than 7u,
//      and its length by 3.5u: kAreaSlack = 16u, times |x||y|. What the frame lost below 2^-1022, and underflow, is
//      scaled by 2^900 at most: kAreaOffset = 2^-170, times |x| + |y|.
//
// (R14) Volume (engine/mesh/topology). Where each edge is passed once in each direction, 6V is the sum over the
// triangles of
//      det(p-o, q-p, r-p), for any point o. o is near the box's centre, and a power of two, at most 2^1000, scales the
//      differences to at most 1 in magnitude. A computed one has a relative error of u. A determinant is the sum of six
//      products of three differences; a product gathers 3u from them, 2u from its multiplications and at most 3u from
//      the sums, so the determinant errs by less than 9u P, P the sum of the absolute values of the products. It is at
//      most P. Its sum over n triangles is that of n/m + 1 blocks of at most m = kVolumeBlock; a term takes part in at
//      most min(n, m) + n/m + 1 sums, so the sum errs by that times u (1 + 2^-20) sum P. The computed sum P has a
//      relative error below (n + 16) u < 2^-22. kVolumeSlack = 16u holds the 9u, these factors and the rounding of the
//      error itself. What underflows is below 2^-1070 for each of at most 2^30 triangles: kVolumeOffset = 2^-1000.
//
// (R15) Cuts (engine/mesh/pieces.h), in the meshes' unit. A height above a plane across an axis is a difference, with a
//      relative error of u and the right sign. Another one, n . (x - o) - r with |n| - 1 <= 4u, errs by u for each
//      difference, 4u for products and sums, and u for the last: less than 8u (|x - o|_1 + |r|). A corner that may be
//      off by `off` adds |n| off. Adding both to the height costs u of the sum: height_error(), with 16u for 9u. The
//      parameter of a crossing is a quotient of heights: 4u of their own, 2u of the operations, so it moves a
//      coordinate by 6u |b - a|; the difference, the product and the sum by u |b - a|, u |b - a| and u max(|a|, |b|).
//      crossing_error() has 16u and 2u, and 2^-1070 for underflow.
//
// (R16) Rays (engine/extras/area/winding). For a corner v let q = v - p, N = |q_x| + |q_y| + |q_z|. A difference has a
//      relative error of u; q_x - s q_z, |s| < 1/2, errs by at most u |q_x| + 2u |q_z| + u N < 3u N, and is below N in
//      magnitude. An edge function x_a y_b - x_b y_a errs by 12u N_a N_b from its coordinates, 2u N_a N_b from its
//      products and 2u N_a N_b from its sum: kRaySlack = 32u. The volume is the sum of three edge functions times
//      heights; each product errs by 16u, u and 2u times N_a N_b N_c from its factors and itself, and both sums by 12u:
//      less than 4 * kRaySlack. Underflow: kRayOffset = 2^-1000.
//
// (R17) Rigid motion (engine/mesh/rigid.h). Lengths are in the meshes' unit. A coordinate is r.x + t for the stored
// numbers.
//      The three products and the three sums leave six errors, each known exactly, by fused multiplication and by
//      Knuth's sum: r.x + t = z + (their sum). Their sum c is computed with five roundings of partial sums, so it errs
//      by at most 6u times the sum S of the absolute values, which itself is computed with a relative error below 6u;
//      and z + c = z' + d with d known exactly. So z' errs by at most |d| + 8u S: kMotionSlack = 8u. Where an entry of
//      r is neither 0 nor 1 in magnitude, a product's error may underflow: 2^-1075 for each. Coordinates and t are at
//      most 2^1020: nothing overflows. As a vector sqrt(3) times the largest of a coordinate; 7/4 of it holds the
//      roundings. A point of a triangle moves no farther than its corners do (R8). If the mesh is within e of the
//      surface that it stands for (R8), the exact images of both are within |r| e, and |r|^2 is the largest eigenvalue
//      of r^T r, below 1 + 3 * 2^-48.
//
// (R18) Cells. Derived where it is used, in engine/extras/area/part.h: kCellLevels = 8, cell_error().
#pragma once

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace meshgauge::rounding {

static_assert(FLT_EVAL_METHOD == 0, "operations on doubles must be rounded to doubles: no x87 (-mfpmath=sse)");

inline constexpr double kUnit = 0x1p-53;  // u

inline constexpr double kDistanceSlack = 64 * kUnit;      // R3, without the residual
inline constexpr double kResidualSlack = 16 * kUnit;      // R2
inline constexpr double kUsualResidual = 512 * kUnit;     // R9
inline constexpr double kMidpointSlack = 2 * kUnit;       // R4, a level
inline constexpr double kSeparationSlack = 32 * kUnit;    // R5
inline constexpr double kOffsetPad = 0x1p-22;             // R6, relative
inline constexpr double kOverlayOffset = 128 * kUnit;     // R7
inline constexpr double kOverlaySlack = 128 * kUnit;      // R7
inline constexpr double kOverlayBaseSlack = 512 * kUnit;  // R7, above a base
inline constexpr double kCutSlack = 48 * kUnit;           // R10

inline constexpr double kPatchSlack = 128 * kUnit;         // R11
inline constexpr double kPatchOffset = 128 * kUnit;        // R11
inline constexpr double kPatchThinnest = 0x1p10;           // R11
inline constexpr double kPatchSmallest = 0x1p-200;         // R11
inline constexpr double kPatchNarrowest = 0x1p-30;         // R11
inline constexpr double kPatchHeightError = 1024 * kUnit;  // R11, times the condition of the triangle

inline constexpr double kMinorantSlack = 64 * kUnit;  // R12
inline constexpr double kCutPointSlack = 16 * kUnit;  // R12, a level
inline constexpr double kCutValueSlack = 32 * kUnit;  // R12
inline constexpr double kShareSlack = 32 * kUnit;     // R12
inline constexpr double kMeanSlack = 32 * kUnit;      // R12
inline constexpr double kAreaSlack = 16 * kUnit;      // R13
inline constexpr double kAreaOffset = 0x1p-170;       // R13

inline constexpr double kVolumeSlack = 16 * kUnit;     // R14
inline constexpr double kVolumeOffset = 0x1p-1000;     // R14
inline constexpr std::size_t kVolumeBlock = 4096;      // R14, triangles
inline constexpr int kSmallestVolumeExponent = -1000;  // R14

inline constexpr std::uint32_t kCellLevels = 8;  // R18, of cuts

inline constexpr double kRaySlack = 32 * kUnit;    // R16, times the sizes of the corners
inline constexpr double kRayOffset = 0x1p-1000;    // R16
inline constexpr double kMotionSlack = 8 * kUnit;  // R17

// Pieces shorter than this are not split: rounding is larger than they are.
inline constexpr double kSmallestPiece = 0x1p-50;

// More levels than any piece is ever split: a coordinate has 53 bits, and bisecting the longest edge reached
// kSmallestPiece within 106 levels for every shape tried.
inline constexpr std::uint32_t kDepthAllowance = 256;

// The relative error of a sum of this many terms >= 0, weights of parts times values: R12.
inline double sum_error(std::size_t terms) { return 2 * kUnit * static_cast<double>(terms + 2 * kDepthAllowance); }

// The area, doubled, that may be wrong or missing in the cells of a triangle with that longest edge: R18.
inline double cell_error(std::size_t cells, std::size_t parts, double longest) {
  return static_cast<double>(cells) * (1024 * kUnit * longest + 0x1p-88) +
         static_cast<double>(parts) * (128 * kUnit * longest * longest);
}

// The error of the sum of that many determinants, `size` the sum of the absolute values of their products: R14.
inline double volume_error(std::size_t triangles, double size) {
  const std::size_t sums = (triangles < kVolumeBlock ? triangles : kVolumeBlock) + triangles / kVolumeBlock + 1;
  return (kVolumeSlack + 2 * kUnit * static_cast<double>(sums)) * size + kVolumeOffset;
}

// The search itself stops at this gap between its computed U and L, whatever tolerance was asked for.
// At least kSmallestPiece, so that unsplittable pieces end the search instead of being asked for again.
inline constexpr double kSmallestGap = 0x1p-49;

// The smallest gap that the overlay bound has to resolve. Its outward offsets grow at sharp corners, so that even for a
// piece that lies on B the bound is well above kOverlaySlack. Without this limit, equal surfaces under a tolerance of
// zero would be bisected down to kSmallestPiece everywhere.
inline constexpr double kOverlayGap = 0x1p-40;

// The smallest gap that the owner cut has to resolve: kCutSlack and the rounding of the points of equal distances.
inline constexpr double kCutGap = 0x1p-46;

// The slack of an upper bound computed at the corners of pieces: R3 + R4. `residual`: the largest of B's triangles.
inline double upper_slack(double residual, std::uint32_t max_depth) {
  return kDistanceSlack + residual + kMidpointSlack * max_depth;
}

// The error of R8 for a mesh whose largest scaled coordinate is `largest` in magnitude.
inline double scaling_error(double largest) { return 6 * kUnit * largest + 0x1p-1072; }

// What a height above a plane may be off at a corner that may be off by `off`, `size` the sum of the absolute values of
// its terms: R15.
inline double height_error(double off, double size) { return off * (1 + 16 * kUnit) + 16 * kUnit * size + 0x1p-1070; }

// What a coordinate between a and b on an edge may be off: R15.
inline double crossing_error(double a, double b) {
  return 16 * kUnit * std::abs(b - a) + 2 * kUnit * std::max(std::abs(a), std::abs(b)) + 0x1p-1070;
}

// The error of R17 for a mesh within `before` of its surface, `largest` that of a coordinate.
inline double motion_error(double largest, bool products_are_exact, double before) {
  const double of_rounding = 1.75 * largest + (products_are_exact ? 0 : 0x1p-1072);
  return before == 0 && of_rounding == 0 ? 0 : (of_rounding + before) * (1 + 0x1p-40) + 0x1p-1072;
}

// Return the next number below x and above x: a rounded result moved away from the exact one.
double down(double x);
double up(double x);

// Return x * 2^exponent, rounded towards +infinity or towards zero. Precondition: x >= 0; x and the result are finite.
double scale_up(double x, int exponent);
double scale_down(double x, int exponent);

// Return a number >= a + b, and max(0, a number <= a - b). Precondition: the arguments are finite.
double add_up(double a, double b);
double subtract_down(double a, double b);

// Return the nearest float >= x and the nearest float <= x. Precondition: |x| is below the largest float.
inline float float_up(double x) {
  const auto f = static_cast<float>(x);
  const auto bits = std::bit_cast<std::uint32_t>(f);  // the next larger float has one more, or one less if f < 0
  return std::bit_cast<float>(bits + (static_cast<double>(f) < x ? 1 - 2 * (bits >> 31) : 0));
}
inline float float_down(double x) { return -float_up(-x); }

}  // namespace meshgauge::rounding
