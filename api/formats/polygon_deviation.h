// How far two splits of one face into triangles can be apart, where its corners are not in one plane.
//
// Apart: the Hausdorff distance H of the two surfaces. A split: triangles without new corners that, seen along the
// face's normal, cover the outline's region once.
//
// (D1) Heights. Let z be the corners' heights along a direction in which the face is simple. Two splits are graphs over
// one
//      region, and straight lines along that direction meet both, so H <= max z - min z. With heights along a normal n
//      but simple along an axis k alone, a point is moved along k: H <= (max z - min z) / |n_k|, n a unit vector.
//
// (D2) Crossings. Let x be on a triangle t of the first split, above (or below) the triangle t' of the second. The
// distance to t' is
//      convex, so over the part of t that lies above t' it is largest at a corner of that part. Those are corners of
//      the face, where it is 0, and crossings of an edge of t with an edge of t', seen along the direction. Edges on
//      the outline are parts of both. So H is at most the largest distance, over all pairs of diagonals that cross, of
//      the crossing on one from the other. Each diagonal is part of some split. Where three corners lie on one line,
//      a corner of one split may lie on an edge of the other, which is no crossing: D1 bounds such faces.
//
// (D3) Four corners a, b, c, d, convex: the splits are by ac and by bd. The distance from x on the triangle abc to the
// second split is the
//      least of those to abd and to bcd. On the ray from b through x both grow until ac (they are convex, and 0 at b).
//      Likewise on acd, so the farthest point is on ac, where the distance to abd, 0 at a, grows towards c, and that to
//      bcd falls: the two meet at the maximum, which bisection encloses. H is the larger of that and of the same along
//      bd. The heights of x above the planes of abd and bcd are linear, so H >= 3V / (area abd + area bcd), V the
//      tetrahedron's volume. With g the distance between the lines ac and bd, N = ac x bd: V = g |N| / 6. So g / H is
//      at most the area of either split over |N| / 2: where that is below 2, g itself will do (with D1, where ac and bd
//      cross along N).
#pragma once

#include <array>
#include <span>

#include "api/formats/outline.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// Upper bounds of H for all splits of one face, rounded up, and at most twice what two splits can be apart; D1 alone,
// which may be more, once the budget is spent. Preconditions: finite coordinates of at most 2^150, `normal` not zero.

// Whether the diagonals of four corners cross, seen along their normal: both are splits.
bool diagonals_cross(const std::array<Vec3, 4>& corners);

// Of a face of four corners that is convex, seen along an axis or its normal. Of no interest up to `of_interest`: any
// bound up to that may be returned.
double quad_deviation(const std::array<Vec3, 4>& corners, double of_interest, StepBudget& budget);

// Of any face that is simple, seen along the largest axis of its normal. Of more than kMostMeasuredCorners corners: D1.
inline constexpr std::size_t kMostMeasuredCorners = 32;
double polygon_deviation(std::span<const Vec3> corners, const Vec3& normal, StepBudget& budget);

// The largest less the smallest height of the corners along the normal (of any length), rounded up.
double thickness(std::span<const Vec3> corners, const Vec3& normal);

// D1 for a face that is simple, seen along the largest axis of its normal.
double deviation_along_axis(std::span<const Vec3> corners, const Vec3& normal);

}  // namespace meshgauge::api
