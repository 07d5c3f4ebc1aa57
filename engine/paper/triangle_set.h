// The bound of Tang, Lee, Kim, "Interactive Hausdorff distance computation for general polygonal models", 2009
// ([TLK09]; the paper's eq. 11): all candidate triangles that can matter for a triangle of A.
//
// Statement. Let c >= h(S,B) for a triangle S of A, and L = { T of B : d(S,T) <= c }. Then
//   for every v in S:        d(v,B) = min over T in L of d(v,T),
//   for every piece P of S:  h(P,B) <= min over T in L of max over corners v of d(v,T).
// Proof. Let T* own the point of B nearest to v. d(S,T*) <= d(v,T*) = d(v,B) <= h(S,B) <= c, so T* is in L; the other
// triangles of L are no nearer. The second part is eq. 8, which holds for any set of triangles (piece.h).
// So L is found once for S, when the traversal bounds it, and serves all its pieces, without further queries.
//
// Rounding can only leave out a triangle of L whose distance is c to within kSetMargin: a corner's distance might then
// come out too large, never a bound too small; and the lower bound is certified from scratch in the end.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/search/piece.h"
#include "engine/search/search.h"
#include "engine/tree/triangle.h"

namespace meshgauge {

struct CornersAndFrame {
  std::array<Vec3, 3> corners;
  PreparedTriangle prepared;
};

// Returns d(S,T) of two triangles in the unit frame; 0 where they pierce, touch or overlap. Degenerate triangles are
// segments or points. The result is within some units of rounding of the true distance.
double triangle_distance(const CornersAndFrame& s, const CornersAndFrame& t);

class TriangleSet final : public PieceBound {
 public:
  explicit TriangleSet(Search& search) : search_(search) {}

  Corner measure(const Vec3& p, const Piece& parent) override;
  double upper(const Piece& piece) override;
  std::size_t memory_bytes() const override { return memory_bytes_; }

 private:
  using Slots = std::vector<std::uint32_t>;

  struct Collected {
    Slots slots;
    bool complete;
  };

  double upper_of_whole(const Piece& whole);
  // Collects L for a whole triangle of A. Incomplete if interrupted: it still gives valid bounds, but no distances.
  Collected collect(const Piece& whole);
  // Returns the kept L of the triangle that holds `piece`; nullptr: its collecting was interrupted.
  const Slots* set_of(const Piece& piece) const;

  Search& search_;
  std::unordered_map<std::uint32_t, Slots> sets_;  // by triangle of A
  std::size_t memory_bytes_ = 0;
};

}  // namespace meshgauge
