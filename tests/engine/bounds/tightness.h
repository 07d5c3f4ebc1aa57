// Tightness: by how much a strategy's bound exceeds the distance that it bounds, the paper's eq. 13. For the evaluation
// of strategies, not for measurements.
//
// Definition. For a triangle S of A and an upper bound U of h(S,B):  tau = (U - h(S,B)) / h(S,B). Smaller is tighter.
//
// Statement, in exact arithmetic, for one S:
//  1. tau >= 0, because U >= h(S,B).
//  2. tau of n_point never rises from a stencil to the next. Cutting a triangle uniformly keeps its corners, and its
//     centroid becomes that of the middle part, so each stencil holds the samples of the one before; the minimum over
//     more owners is not larger.
//  3. triangle_set has the least tau of all: its bound is the least of eq. 8 over all triangles of B. Its L holds every
//     T with d(S,T) <= c, where c = max over corners v of d(v,T') for some T' of B; the T* that attains the least has
//     d(S,T*) <= max over v of d(v,T*) <= c.
//
// Rounding: U is computed without slack, and equidistant owners of a sample and triangles within kSetMargin of c may be
// missed, so 1 to 3 hold to within some 1e-15 of the unit frame, and what h is known to.
#pragma once

#include "engine/hausdorff.h"

namespace meshgauge {

inline constexpr double kTightnessError = 1e-9;  // of h, as in the paper; unit frame

// Returns h(triangle of `a`, B) to within kTightnessError, by subdivision. Precondition: the meshes are in the unit
// frame.
inline double distance_by_subdivision(const Mesh& a, std::uint32_t triangle, const Mesh& b) {
  Mesh one;
  for (const std::uint32_t corner : a.triangles[triangle]) one.positions.push_back(a.positions[corner]);
  one.triangles.push_back({0, 1, 2});
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {kTightnessError, std::nullopt, std::nullopt};
  Control control;
  const Outcome found = measure(one, b, options, control);
  return (found.lower + found.upper) / 2;
}

// Precondition: h > 0.
inline double tightness(double upper, double h) { return (upper - h) / h; }

}  // namespace meshgauge
