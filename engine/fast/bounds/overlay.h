// The overlay bound: triangles of B, seen along the normal of a piece, cover it, and each one bounds its own part.
//
// Setting. Let P be a piece, and pi a map of B's vertices into P's plane, extended linearly over each triangle. Here pi
// is the projection along P's normal, but the proof only needs that it maps equal positions to equal points. Lay B's
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
// holds for it unchanged. It remains to show that the comparisons between images err to the safe side:
//
//  1. Polygons are clipped by half-planes moved outwards by kOffset. A signed distance errs by at most 32u, and a cut
//     point is within 12u of its edge. So after the at most 3 cuts the computed polygon, widened by 36u, contains the
//     exact one if kOffset >= 36u + 32u. kOffset = 128u.
//
//  2. "Meets P" clips the edge by P's sides moved outwards. The place of a cut errs by 4u of the edge's length, for
//     which the comparison of two cuts leaves room: it errs towards yes.
//
//  3. "Strictly on the other side" requires kOffset on both sides: it errs towards no. If an image is thinner than
//     that, the attempt fails.
//
//  4. y0 is inside of all six sides by kOffset, or taken from a polygon clipped by half-planes moved *inwards*, so it
//     is in P and in pi(T0) exactly.
//
//  5. "Beyond" requires kOffset. A side of a wedge is left out if the other end of the edge is closer to it than that,
//     which only makes the shadow larger.
//
//  6. A corner's point in space errs by 10u, and by 36u from clipping. P itself is off by the residual of its frame,
//     which is at most 32u, or the attempt fails. kOverlaySlack = 128u is added to the result.
//
//  7. A base changes by at most twice what a point errs by, 6: 2 * 78u; its value errs by 64u, once there and once
//     where the caller adds it. kOverlayBaseSlack = 512u is added instead.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/fast/bounds/polygon.h"
#include "engine/mesh/adjacency.h"
#include "engine/search/piece.h"

namespace meshgauge {

// The triangles seen by one flood: a small open-addressed table.
class SeenTriangles {
 public:
  // Empties the table for a new flood and makes room for `most` triangles.
  void start(std::size_t most);
  bool holds(std::uint32_t triangle) const { return entries_[place_of(triangle)] == entry(triangle); }
  void add(std::uint32_t triangle) { entries_[place_of(triangle)] = entry(triangle); }

 private:
  std::uint64_t entry(std::uint32_t triangle) const { return (std::uint64_t{flood_} << 32) | triangle; }
  // The place of the triangle, or the free place for it.
  std::size_t place_of(std::uint32_t triangle) const {
    std::size_t i = triangle & (entries_.size() - 1);
    while (entries_[i] >> 32 == flood_ && entries_[i] != entry(triangle)) i = (i + 1) & (entries_.size() - 1);
    return i;
  }

  std::vector<std::uint64_t> entries_;  // upper half: number of the flood; lower half: triangle
  std::uint32_t flood_ = 0;
};

// One object for each thread.
class Overlay {
 public:
  // `adjacency`: of the target's mesh. Both must outlive the object.
  Overlay(const Bvh& target, const Adjacency& adjacency);
  ~Overlay();

  // A function value + slope . (x - origin) to bound the distance above: upper bounds d(x,B) - base(x) for all x of the
  // piece. The statement above holds for d(.,T) - base, too, which is convex. Precondition: |slope| <= kMostSlope.
  struct Base {
    Vec3 origin;
    double value = 0;
    Vec3 slope = Vec3::Zero();
    double operator()(const Vec3& x) const { return value + dot(slope, x - origin); }
  };
  static constexpr double kMostSlope = 2;

  struct Attempt {
    bool started = false;         // one of `starts` lies over the piece, or the bound is impossible for it
    std::optional<double> upper;  // of h(piece, B), or above the base, slack included, at most `limit`; nullopt: failed
    std::optional<Vec3> too_far;  // after a failure, if known: an attempt for a part that holds this point fails, too
  };

  // Tries to show that h(piece, B) is at most `limit`. Fails as soon as that is refuted, when more than `max_visits`
  // triangles lie over the piece, or when an image is too thin or the frame too coarse (3 and 6 above). `starts`:
  // triangles of B, or Nearest::kNone, which is passed over; the flood begins in the first one that lies over the
  // piece. `base`: null: 0. Adds the computed point-triangle distances to `work`.
  Attempt attempt(const Piece& piece, std::span<const std::uint32_t> starts, double limit, std::size_t max_visits,
                  Work& work, const Base* base = nullptr);

  // A part of a piece and the triangle of B that is seen over it.
  struct Cell {
    std::uint32_t triangle;
    Polygon polygon;
  };
  // Cells in the plane of the piece's prepared triangle.
  struct Cells {
    PreparedTriangle frame;
    std::span<const Cell> cells;
  };
  // Divides the piece into the parts that B's triangles lie over: each of its points is within 36u of a cell. Cells may
  // overlap. nullopt: as a failed attempt(), or an edge is blocked. The result is valid until the next call.
  std::optional<Cells> cells(const Piece& piece, std::span<const std::uint32_t> starts, std::size_t max_visits,
                             Work& work);

 private:
  struct View;
  struct Image;

  bool start(View& view, std::span<const std::uint32_t> starts, std::size_t max_visits);
  bool flood(View& view, std::size_t max_visits, Work& work);
  bool visit(View& view, const Image& image, Work& work);
  bool cross(const View& view, const Image& image, std::uint32_t edge, const HalfPlane& side);

  const Bvh& target_;
  const Adjacency& adjacency_;
  SeenTriangles seen_;
  std::vector<Image> open_;
  std::vector<Cell> cells_;
};

}  // namespace meshgauge
