// The end of a search: computed bounds become certified ones, in the file's own unit.
#pragma once

#include <optional>

#include "engine/frame.h"
#include "engine/search.h"

namespace meshgauge {

// lower <= h(A,B) <= upper for the search's two meshes, and the witness, whose exact distance to B is at least lower.
//
// Lower: the witness as reported, w, is the candidate rounded to the file's coordinates. With r >= d(w, A) some point
// of A is within r of w, and d(., B) is 1-Lipschitz, so h(A,B) >= d(w,B) - r. Both are bounded by rounding.h R5 and R3.
// Upper: every point of A lies in a piece whose computed bound is in search.upper(); R3 and R4 give the slack.
//
// The lower bound costs two queries and depends on the candidate alone: it is kept until there is another one. One
// object a search.
class Certifier {
 public:
  Bounds certify(const Search& search, const Frame& frame);

 private:
  struct Known {
    Vec3 candidate;
    std::uint32_t triangle;
    double lower;  // frame units
    Witness witness;
  };
  static Known lower_bound(const Search& search, const Frame& frame);

  std::optional<Known> known_;
};

}  // namespace meshgauge
