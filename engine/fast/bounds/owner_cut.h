// The owner cut: a piece is divided where the distances from two triangles of B are equal, and each part is bounded by
// its own triangle.
//
// Where the surface of A crosses points that are equally far from two sheets of B, no single triangle bounds a piece
// well: the bound of eq. 9 errs by the piece's width, so bisection would need 1/tolerance pieces along such a line. The
// parts beside a cut along the line err by the square of the width, or by nothing if the line is straight.
//
// Statement. Let P be a triangle p0 p1 p2, S and T any triangles of B, r a point of p0p1 and s one of p0p2. Then
//   h(P,B) <= max( max over c in {p0,r,s} of d(c,S), max over c in {r,p1,p2,s} of d(c,T) ).
// If P is divided into triangles, the largest of their bounds, by the above or by eq. 9, bounds h(P,B).
// Proof. P is the union of the triangle p0 r s and the quadrilateral r p1 p2 s, both convex, and d(.,S) and d(.,T) are
// convex: their maxima are at corners. So the bound holds wherever the cut is and whatever the triangles; where the
// distances are equal it is tight.
//
// Rounding. A cut point a + t (b - a), t in [0,1], errs by 2u in the difference, 2u in the product and u in the sum on
// each axis: as a vector by less than 9u. A midpoint errs by less than 2u (rounding.h, R4), and P is bisected kMaxDepth
// = 16 times at most. Both kinds of points are convex combinations of earlier ones, so errors add up but do not grow:
// a computed point is within 2u * 16 + 9u = 41u of the point of the division by exact points. A point x of an exact
// part is a convex combination of its exact corners, so d(x,T) is at most the same combination of their distances, and
// these are within 41u of those of the computed corners. kCutSlack = 48u is added to the bound. The distances
// themselves are those of rounding.h, R3.
#pragma once

#include <optional>

#include "engine/search/piece.h"

namespace meshgauge {

// The bound of one piece. Not thread safe.
class OwnerCut {
 public:
  static constexpr std::size_t kMaxOwners = 6;
  static constexpr int kMaxDepth = 16;  // bisections

  // Begins with the nearest triangles of the piece's corners. Borrows all three; adds the computed point-triangle
  // distances to `work`.
  OwnerCut(const Piece& piece, const Bvh& target, Work& work);

  // Takes one more triangle of B into account. False: it is known, or there are kMaxOwners already.
  bool add(std::uint32_t slot);

  struct Attempt {
    std::optional<double> upper;  // upper bound of h(piece, B), slack included, at most `limit`; nullopt: failed
    // After a failure, if known: a point of the piece that is farther than the limit from all triangles taken into
    // account. Either another triangle is nearer to it, or it is farther from B.
    std::optional<Vec3> too_far;
  };
  // Tries to show that h(piece, B) is at most `limit`, with at most `parts` triangles, the piece itself included.
  Attempt attempt(double limit, int parts);

 private:
  struct Point {
    Vec3 at;
    std::array<double, kMaxOwners> distances;  // from each owner
  };
  using Part = std::array<Point, 3>;
  enum class Verdict { bounded, open, too_far };

  double from_owner(std::size_t i, const Vec3& x) const;
  Point measured(const Vec3& x) const;
  Verdict bound(const Part& part, int depth);
  bool bounded_by_one(const Part& part);
  Verdict bound_by_pair(const Part& part, std::size_t i, std::size_t j);
  Verdict bisect(const Part& part, int depth);
  Verdict cross(const Point& a, const Point& b, std::size_t i, std::size_t j, double& upper);
  bool beyond_all(const Vec3& x);

  const Piece& piece_;
  const Bvh& target_;
  Work& work_;
  std::array<std::uint32_t, kMaxOwners> owners_;
  std::size_t count_ = 0;  // of owners
  double limit_ = 0;       // without the slack
  int parts_ = 0;          // that may still be tried
  double upper_ = 0;       // of the parts that are bounded
  std::optional<Vec3> too_far_;
};

}  // namespace meshgauge
