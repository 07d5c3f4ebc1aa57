// Tightness: how much a strategy's bound loses because it uses few triangles of B. For the evaluation of strategies,
// not for measurements. The paper's eq. 13 treats the same question; the definition is this project's own.
//
// Definition. For a piece P let f(T) = max over corners v of d(v,T). Every strategy's bound is the minimum of f over
// its candidates L (eq. 8). Its tightness is
//
//   ( min of f over ALL triangles of B ) / ( min of f over L ),   and 1 where both are 0.
//
// Statement. It lies in [0,1]; 1 means that L loses nothing. More candidates never lower it.
// Proof. L is a subset of B's triangles: the numerator, the minimum over a larger set, is not above the denominator,
// and is 0 where the denominator is. Enlarging L can only lower the denominator.
//
// For whole triangles S of A it follows:
//
//  1. triangle_set has tightness 1. Its L holds every T with d(S,T) <= c, where c = min of f over some triangles. The
//     T* that attains the numerator has d(S,T*) <= f(T*) <= c.
//
//  2. The tightness of n_point never falls from a stencil to the next: cutting a triangle uniformly keeps its corners,
//     and its centroid becomes that of the middle part; so each stencil holds the samples of the one before.
//
//  3. 0 is possible, but only where B overlaps itself: P lies in one triangle of B, other triangles own all samples.
//
// Rounding. Both minima are of the same computed f(T), so the ratio is never above 1. A bound within rounding of 0, at
// most rounding::kDistanceSlack + B's residual, counts as 0. Equidistant owners of a sample, and triangles of
// triangle_set within kSetMargin of c, can make 1 and 2 fail, which hold in exact arithmetic.
#pragma once

#include <numeric>
#include <vector>

#include "engine/bounds/piece.h"
#include "engine/rounding.h"

namespace meshgauge {

// Returns the minimum of f over all triangles of B, by brute force. Computed without slack, like every bound.
inline double best_upper(const Piece& piece, const Bvh& target) {
  // Uses the function of the strategies, so that the same triangle has the same computed value.
  std::vector<std::uint32_t> all(target.mesh().triangles.size());
  std::iota(all.begin(), all.end(), 0U);
  Work uncounted;
  return least_farthest(piece, target, all, uncounted);
}

// Returns the tightness of `upper`, a bound from PieceBound::upper(). `best`: best_upper(). Both are >= 0 and in the
// unit frame.
inline double tightness(double best, double upper, const Bvh& target) {
  if (upper <= rounding::kDistanceSlack + target.residual()) return 1;
  return best / upper;
}

}  // namespace meshgauge
