// The end of a search: computed bounds become certified ones, in the file's own unit.
#pragma once

#include "engine/frame.h"
#include "engine/search.h"

namespace meshgauge {

// lower <= h(A,B) <= upper for the search's two meshes, and the witness, whose exact distance to B is at least lower.
//
// Lower: the witness as reported, w, is the candidate rounded to the file's coordinates. With r >= d(w, A) some point
// of A is within r of w, and d(., B) is 1-Lipschitz, so h(A,B) >= d(w,B) - r. Both are bounded by rounding.h R5 and R3.
// Upper: every point of A lies in a piece whose computed bound is in search.upper(); R3 and R4 give the slack.
Bounds certify(const Search& search, const Frame& frame);

}  // namespace meshgauge
