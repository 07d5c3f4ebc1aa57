// The overlay bound: the piece is covered by triangles of B seen along its normal, and each one bounds its own part.
//
// Setting. Let P be a piece, and pi a map of B's vertices into P's plane, extended linearly over each triangle: here
// the projection along P's normal, but the proof needs no more than that equal positions go to equal points. Lay B's
// triangles over P by pi. Let T0 be a triangle of B whose image is not degenerate, and y0 a point in P and in pi(T0).
// Flood from T0: from T cross an edge whose image meets P, and only into a neighbour whose apex (its corner off that
// edge) lies strictly to the other side of the edge's image than T's apex. Edges that meet P but may not be crossed are
// blocked.
//
// Statement. Every x in P is in pi(T) for some visited T, or in the shadow of a blocked edge e of a visited T: the part
// of P beyond e's line (away from T), inside the wedge from y0 through e's ends. If y0 itself is beyond e's line, e has
// no shadow. So
//   h(P,B) <= max over visited T of max over corners c of (pi(T) n P) of d(c,T),
//             and over shadows of max over their corners c of d(c,T') with T' any one triangle of B.
// Proof. Walk the segment y0 -> x and lift it triangle by triangle. It leaves pi(T) through an edge, at a point of P (P
// is convex), so that edge meets P; if the edge is not blocked the neighbour's image lies beyond it and takes over, and
// the walk never comes back (an image is convex). It ends at x, which then is in pi(T) of a visited T, or at a blocked
// edge e, crossed outwards: then the rest of the segment, x included, is in P, beyond e's line and in the wedge; this
// needs y0 on T's side of the line. (Segments through images of vertices are limits of segments that avoid them, and
// the covered sets are closed.) Both kinds of sets are convex, and d(.,T) is convex, so corners suffice.
//
// Most of the time no polygon is needed: pi(T) n P lies in pi(T), whose corners are images of T's own corners v, and |v
// - pi(v)| bounds d(pi(v), T). Only when that is too much for some corner of T is the polygon clipped and its corners
// measured.
//
// Rounding. The images are taken as computed: pi is then an exact map onto floating-point points, and the statement
// holds for it as it is. What remains is to err to the safe side when comparing them:
//  * Polygons are clipped by half-planes moved outwards by kOffset. A signed distance errs by at most 32u and a cut
//  point is within
//    12u of the edge it is on, so after the at most 3 cuts the computed polygon, widened by 36u, contains the exact one
//    if kOffset >= 36u + 32u. kOffset = 128u.
//  * "Meets P" clips the edge by P's sides moved outwards, and where it is cut errs by 4u of its length: towards yes.
//  "Strictly on the other side" asks for kOffset on both
//    sides: errs towards no. A triangle whose image is thinner than that is not trusted: the attempt ends.
//  * y0 is taken from a polygon clipped by half-planes moved *inwards*, so it is in P and in pi(T0) exactly. "Beyond"
//  asks for kOffset.
//    A side of a wedge on which the other end of the edge is closer than that is left out, which only makes the shadow
//    larger.
//  * A corner's point in space errs by 10u, and 36u from clipping; P itself is off by the residual of its frame, which
//  is at
//    most 32u or the bound is not used. kOverlaySlack = 128u is added to the result.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/adjacency.h"
#include "engine/bounds/piece.h"
#include "engine/bounds/polygon.h"

namespace meshgauge {

// Triangles seen by one flood: a small open-addressed table, emptied by starting the next flood.
class SeenTriangles {
 public:
  // Room for `most` triangles.
  void start(std::size_t most);
  bool holds(std::uint32_t triangle) const { return entries_[place_of(triangle)] == entry(triangle); }
  void add(std::uint32_t triangle) { entries_[place_of(triangle)] = entry(triangle); }

 private:
  std::uint64_t entry(std::uint32_t triangle) const { return (std::uint64_t{flood_} << 32) | triangle; }
  // Where it is, or the free place where it would be.
  std::size_t place_of(std::uint32_t triangle) const {
    std::size_t i = triangle & (entries_.size() - 1);
    while (entries_[i] >> 32 == flood_ && entries_[i] != entry(triangle)) i = (i + 1) & (entries_.size() - 1);
    return i;
  }

  std::vector<std::uint64_t> entries_;  // number of the flood and the triangle
  std::uint32_t flood_ = 0;
};

// One a thread.
class Overlay {
 public:
  // `adjacency` is that of the target's mesh; both must outlive this.
  Overlay(const Bvh& target, const Adjacency& adjacency);
  ~Overlay();

  struct Attempt {
    bool started = false;         // one of the starts lies over the piece
    std::optional<double> upper;  // of h(piece, B), if it is at most the limit
    std::optional<Vec3> too_far;  // where it failed: the attempt would fail again for a part that holds this point
  };

  // Tries to show that h(piece, B) is at most `limit`, and ends as soon as that fails, or when more than `max_visits`
  // triangles lie over the piece. The flood begins in the first of `starts`, triangles of B, that lies over the piece.
  // `work` counts point-triangle distances.
  Attempt attempt(const Piece& piece, std::span<const std::uint32_t> starts, double limit, std::size_t max_visits,
                  Work& work);

 private:
  struct View;
  struct Image;

  bool visit(View& view, const Image& image, Work& work);
  bool cross(const View& view, const Image& image, std::uint32_t edge, const HalfPlane& side);

  const Bvh& target_;
  const Adjacency& adjacency_;
  SeenTriangles seen_;
  std::vector<Image> open_;
};

}  // namespace meshgauge
