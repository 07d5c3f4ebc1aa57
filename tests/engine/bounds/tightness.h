// How much a strategy's bound loses by looking at few triangles of B: for measuring strategies, not for measuring
// meshes. It is what the paper's eq. 13 is about; the definition is this project's own.
//
// Definition. For a piece P let f(T) = max over corners v of d(v,T). Every strategy's bound is the minimum of f over
// its candidates L (eq. 8). Its tightness is
//
//   ( min of f over ALL triangles of B ) / ( min of f over L ),   and 1 where both are 0.
//
// Statement. It lies in [0,1]; 1 means that nothing was lost by looking at L alone. More candidates never lower it.
// Proof. L is a subset of B's triangles: the numerator, the minimum over a larger set, is not above the denominator,
// and is 0 where the denominator is. Enlarging L can only lower the denominator.
//
// For whole triangles S of A it follows that:
// * triangle_set has tightness 1. Its L holds every T with d(S,T) <= c, where c = min of f over some triangles. The T*
//   that attains the numerator has d(S,T*) <= f(T*) <= c.
// * n_point's never falls from a stencil to the next: cutting a triangle uniformly keeps its corners, and its centroid
//   becomes that of the middle part; so each stencil holds the samples of the one before.
// * 0 is possible, but only where B overlaps itself: P lies in one triangle of B, other triangles own all samples.
//
// Rounding. Both minima are of the same computed f(T), so the ratio is never above 1. A bound that rounding cannot tell
// from 0, at most rounding::kDistanceSlack + B's residual, counts as 0. Equidistant owners of a sample, and triangles
// of triangle_set within kSetMargin of c, can make the first two bullets fail, which hold in exact arithmetic.
#pragma once

#include <numeric>
#include <vector>

#include "engine/bounds/piece.h"
#include "engine/rounding.h"

namespace meshgauge {

// min of f over all triangles of B, by looking at each of them: O(triangles of B). Computed as every bound is: without
// slack.
inline double best_upper(const Piece& piece, const Bvh& target) {
  // By the very function that the strategies use, so that the same triangle has the same computed value.
  std::vector<std::uint32_t> all(target.mesh().triangles.size());
  std::iota(all.begin(), all.end(), 0U);
  Work uncounted;
  return least_farthest(piece, target, all, uncounted);
}

// The definition, for a bound of h(piece,B) from PieceBound::upper() and for best_upper(), both >= 0. Unit frame.
inline double tightness(double best, double upper, const Bvh& target) {
  if (upper <= rounding::kDistanceSlack + target.residual()) return 1;
  return best / upper;
}

}  // namespace meshgauge
