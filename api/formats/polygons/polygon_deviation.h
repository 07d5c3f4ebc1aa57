// Bounds how far two splits of one face into triangles can be apart when its corners are not in one plane.
//
// A split: triangles without new corners that, seen along the face's normal, cover the outline's region once.
// H: the Hausdorff distance of the surfaces of two splits.
//
// (D1) Heights. Let z be the corners' heights along a direction along which the face is simple. Two splits are graphs
//      over one region, and straight lines along that direction meet both, so H <= max z - min z. If z are heights
//      along a normal n, a unit vector, but the face is simple only along an axis k, move the point along k:
//      H <= (max z - min z) / |n_k|.
//
// (D2) Crossings. Let x be on a triangle t of the first split, above (or below) the triangle t' of the second. The
//      distance to t' is convex, so over the part of t that lies above t' it is largest at a corner of that part. Such
//      a corner is a corner of the face, where the distance is 0, or a crossing of an edge of t with an edge of t',
//      seen along the direction. Edges on the outline belong to both splits. So H is at most the largest distance, over
//      all pairs of diagonals that cross, from the crossing on one diagonal to the other diagonal. Each diagonal is
//      part of some split. Where three corners lie on one line, a corner of one split may lie on an edge of the other,
//      which is not a crossing: D1 bounds such faces.
//
// (D3) Four corners a, b, c, d, convex. The splits are by ac and by bd. The distance from x on the triangle abc to the
//      second split is the smaller of those to abd and to bcd. On the ray from b through x both grow until ac (they are
//      convex, and 0 at b). Likewise on acd, so the farthest point is on ac. There the distance to abd, 0 at a, grows
//      towards c, and that to bcd falls: the two are equal at the maximum, which bisection encloses. H is the larger of
//      that and of the same along bd. The heights of x above the planes of abd and bcd are linear, so
//      H >= 3V / (area abd + area bcd), V the tetrahedron's volume. With g the distance between the lines ac and bd and
//      N = ac x bd: V = g |N| / 6. So g / H is at most the area of either split over |N| / 2. Where that is below 2,
//      g itself is a sufficient bound (with D1, where ac and bd cross along N).
#pragma once

#include <array>
#include <span>

#include "api/formats/polygons/outline.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// The functions below return upper bounds of H for all splits of one face, rounded up, at most twice what two splits
// can be apart; once the budget is spent, D1 alone, which may be more. Preconditions: finite coordinates of at most
// 2^150, `normal` not zero.

// Returns true when the diagonals of four corners cross, seen along their normal: then both give a split.
bool diagonals_cross(const std::array<Vec3, 4>& corners);

// Bounds H for a face of four corners that is convex, seen along an axis or its normal. When H is at most
// `of_interest`, any bound up to that may be returned.
double quad_deviation(const std::array<Vec3, 4>& corners, double of_interest, StepBudget& budget);

// Bounds H for any face that is simple, seen along the largest axis of its normal; by D1 alone above
// kMostMeasuredCorners corners.
inline constexpr std::size_t kMostMeasuredCorners = 32;
double polygon_deviation(std::span<const Vec3> corners, const Vec3& normal, StepBudget& budget);

// Returns the largest minus the smallest height of the corners along the normal (of any length), rounded up.
double thickness(std::span<const Vec3> corners, const Vec3& normal);

// Bounds H by D1 for a face that is simple, seen along the largest axis of its normal.
double deviation_along_axis(std::span<const Vec3> corners, const Vec3& normal);

}  // namespace meshgauge::api
