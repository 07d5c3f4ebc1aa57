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
//  * "Meets P" clips the edge by P's sides moved outwards: errs towards yes. "Strictly on the other side" asks for
//  kOffset on both
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
#include <vector>

#include "engine/adjacency.h"
#include "engine/bounds/piece.h"
#include "engine/bounds/polygon.h"

namespace meshgauge {

class Overlay {
 public:
  // `target` must outlive this. Builds the adjacency of its mesh: linear time, 0.3 to 1 us a triangle.
  explicit Overlay(const Bvh& target);
  ~Overlay();

  // An upper bound of h(piece, B) if it is at most `limit`; otherwise, or when more than `max_visits` triangles lie
  // over the piece, none: the attempt then ends as soon as that is known. `work` counts point-triangle distances.
  std::optional<double> upper(const Piece& piece, double limit, std::size_t max_visits, Work& work);

 private:
  struct View;
  struct Image;

  bool visit(View& view, const Image& image, Work& work);
  bool cross(const View& view, const Image& image, std::uint32_t edge, const HalfPlane& side);

  const Bvh& target_;
  Adjacency adjacency_;
  std::vector<std::uint32_t> visited_in_;  // by triangle: the number of the flood that saw it last
  std::uint32_t flood_ = 0;
  std::vector<Image> open_;
};

}  // namespace meshgauge
