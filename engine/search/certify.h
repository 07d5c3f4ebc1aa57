// The end of a search: turns its computed bounds into certified ones, in the meshes' unit.
#pragma once

#include <optional>

#include "engine/mesh/frame.h"
#include "engine/search/search.h"

namespace meshgauge {

// Statement. certify() returns lower <= h(A,B) <= upper for the search's two meshes, and a witness whose exact distance
// to B is at least lower.
//
// Lower: the witness as reported, w, is the candidate rounded to the file's coordinates. With r >= d(w, A) some point
// of A is within r of w, and d(., B) is 1-Lipschitz, so h(A,B) >= d(w,B) - r. Both are bounded by rounding.h R5 and R3.
// Where the tree holds a part of B alone, each other triangle is farther than search.reach() from the candidate's
// triangle, which is within r of w: so d(w,B) is at least the smaller of the distance to the part and reach() - r.
// Upper: every point of A lies in a piece whose computed bound is in search.upper(); R3 and R4 give the slack.
//
// One object for each search. The lower bound costs two queries and depends on the candidate alone, so it is kept until
// the candidate changes.
class Certifier {
 public:
  // Returns bounds in the meshes' unit. The witness names triangles by their numbers in the search's meshes. `stop`:
  // see nearest(). When it ends a query, the lower bound and its witness are those of an earlier candidate, or 0 and
  // the candidate.
  Bounds certify(const Search& search, const Frame& frame, const Interrupted& stop);

 private:
  struct Known {
    Vec3 candidate;
    std::uint32_t triangle;
    double lower;  // frame units
    Witness witness;
    bool complete;  // neither query was stopped
  };
  static Known lower_bound(const Search& search, const Frame& frame, const Interrupted& stop);

  std::optional<Known> known_;
};

}  // namespace meshgauge
