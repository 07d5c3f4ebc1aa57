// The farthest points of one surface from another: a lower bound of h that owes nothing to the engine.
//
// A search in double precision only proposes points; what counts is their exact distance.
#pragma once

#include <vector>

#include "oracle/exact.h"

namespace meshgauge::oracle {

struct Proposal {
  std::size_t triangle = 0;
  Weights weights;
};

// Points of `from` that look far from `to`: best-first bisection up to `max_points` measured points, then a climb from
// the best few. At least the three corners of some triangle.
std::vector<Proposal> propose_farthest(const Surface& from, const Surface& to, std::size_t max_points);

struct Farthest {
  Proposal where;
  Ratio distance_sq;  // exact: h(from, to) is at least its root
};

// The farthest of the points proposed. Precondition: both surfaces have a triangle.
Farthest farthest_sample(const Surface& from, const Surface& to, std::size_t max_points);

// Both in exact arithmetic: sqrt(lower_sq) <= h(from, to) <= sqrt(upper_sq). Best first over pieces of `from`, each
// bounded by the least over triangles T of `to` of its corners' largest distance to T; at most `max_splits` splits in
// four.
struct Bracket {
  Ratio lower_sq;
  Ratio upper_sq;
};
Bracket exact_bracket(const Surface& from, const Surface& to, std::size_t max_splits);

}  // namespace meshgauge::oracle
