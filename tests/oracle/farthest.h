// The farthest points of one surface from another: a lower bound of h that does not depend on the engine.
//
// A search in double precision proposes points; their distances are computed exactly.
#pragma once

#include <vector>

#include "oracle/exact.h"

namespace meshgauge::oracle {

struct Proposal {
  std::size_t triangle = 0;
  Weights weights;
};

// Returns points of `from` that are probably far from `to`: best-first bisection up to `max_points` measured points,
// then a climb from the best few. The result holds at least the three corners of a triangle.
std::vector<Proposal> propose_farthest(const Surface& from, const Surface& to, std::size_t max_points);

struct Farthest {
  Proposal where;
  Ratio distance_sq;  // exact: h(from, to) is at least its root
};

// Returns the farthest of the proposed points. Precondition: both surfaces have a triangle.
Farthest farthest_sample(const Surface& from, const Surface& to, std::size_t max_points);

// Returns sqrt(lower_sq) <= h(from, to) <= sqrt(upper_sq), in exact arithmetic. Goes best first over pieces of `from`,
// each bounded by the minimum over triangles T of `to` of its corners' largest distance to T; makes at most
// `max_splits` splits in four.
struct Bracket {
  Ratio lower_sq;
  Ratio upper_sq;
};
Bracket exact_bracket(const Surface& from, const Surface& to, std::size_t max_splits);

}  // namespace meshgauge::oracle
