// The parts of A that the area search bounds: triangles of A, and what these two make of them.
//
//  * Cuts from a corner to the opposite edge. A cut at a + s (b - a) divides the exact part's area as s : 1 - s,
//    exactly, so weights are divided alike (rounding.h R12).
//
//  * Cells. The overlay (engine/fast/bounds/overlay.h) covers the part P with polygons, each under one triangle T of B.
//    d(.,T) bounds d(.,B) above there, and is mostly equal to it. A polygon that crosses the plane of T is divided
//    along it, since d(.,T) has a crease there. The polygons are divided into triangles from their first corners.
//    Statement. Let the areas of the cells add up to |P| + e, e possibly negative, and let a part of P of area at most
//    r be in no cell. Then the area that is in more cells than one, or outside of P, counted so often, is at most e +
//    r. So with shares x_low <= x <= x_high of the cells C, the share of P is between (sum |C| x_low - e - r) / |P| and
//    (sum |C| x_high + r) / |P|, and with values in [0, m] instead of shares m times e + r and r are in their places.
//    Proof. sum |C| - |union of the C in P| <= |P| + e - (|P| - r).
//    Rounding (R18), u = 2^-53. Each point of P is within 36u of a polygon of the overlay, and a point of a cell's edge
//    within 12u of that edge (overlay.h). A polygon divided along a plane: the two points of the cut are corners of
//    both halves, and each is computed within 12u of its edge, so a point of the polygon is within 12u of a half.
//    Corners on alternating sides, by rounding, give more points, in the order of the outline: then the halves cover
//    the polygon that these points form twice, which e counts, and nothing is missed. A
//    corner in space errs by 10u more, and the frame's residual is below 32u. So a point of P, also one in no cell, is
//    within 36u + 12u + 12u + 10u + 32u of one that a cell bounds, which the slack of kCellLevels cuts exceeds: 8 *
//    16u. Therefore a limit that all cells are within, or beyond, holds for all of P. With L the longest edge, a cell's
//    outline is at most 3L long; what it misses, doubled, is below 2 * (48u * 3L + 3.15 * (48u)^2), and fans of
//    polygons that rounding made concave err by 12uL at a corner. In all less than 1024uL + 2^-88 a cell, halves
//    counted each. The area of a part, doubled, is a difference of two products of differences: it errs by less than
//    128u L^2.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/extras/area/enclosure.h"
#include "engine/extras/area/minorant.h"
#include "engine/fast/bounds/overlay.h"
#include "engine/search/piece.h"
#include "engine/tree/bvh.h"

namespace meshgauge {

struct Part {
  std::array<Corner, 3> corners;
  Enclosure enclosure;
  double weight = 0;  // of its area: AreaWeights
  std::uint32_t depth = 0;
  bool has_low = false;     // enclosure.low is that of its own linear_minorant() or better
  bool is_cell = false;     // made by cells(), or a part of such a part
  bool has_failed = false;  // cells() has
  bool is_open = false;     // the search has found that it needs more work
  bool is_rough = false;    // the corners' distances are those from the triangle of the cell: upper bounds
};

// The cells of a part.
struct CellParts {
  std::vector<Part> parts;
  std::vector<std::size_t> fans;  // the ends of the cells' parts in `parts`
  double error = 0;               // at least |e| + r of the statement, as a weight
};

// A cut of a part from a point of the edge ab to the corner c: numbers of corners.
struct PartCut {
  std::size_t a, b, c;
  double at = 0.5;  // the point is a + at * (b - a)
};

// Bounds parts. One object for each thread.
class PartBounder {
 public:
  // `adjacency`: of `to`. `error`: how far the surfaces may be from the exact ones that they stand for (InputError), in
  // frame units. `limits`, ascending: where the distance to a part is only compared with these; empty: it is wanted.
  PartBounder(const Bvh& to, const Adjacency& adjacency, double error, std::vector<double> limits = {},
              double most_cell_error = 0)
      : to_(to),
        error_(error),
        limits_(std::move(limits)),
        most_cell_error_(most_cell_error),
        overlay_(to, adjacency) {}

  // A whole triangle with measured corners; its enclosure has an upper function and no lower one. `by_overlay`: the
  // overlay is tried, too.
  Part whole(const std::array<Corner, 3>& corners, double weight, bool by_overlay, Work& work);
  // The upper function of a whole triangle by the distances of the corners alone.
  Linear high_of_corners(const std::array<Corner, 3>& corners) const;
  // Adds a lower function; its values need not be more than `most`. False: `stop` returned true; the part is unchanged.
  bool bound_below(Part& part, double most, Work& work, const Interrupted* stop) {
    return bound_fan_below({&part, 1}, most, work, stop);
  }
  // The same for each of several parts of one depth: the triangles of a polygon from its first corner, as cells() makes
  // them. At most kMostOfFan.
  bool bound_fan_below(std::span<Part> fan, double most, Work& work, const Interrupted* stop);
  static constexpr std::size_t kMostOfFan = kMostMinorantPoints - 2;
  // Cuts the part in two, each with the functions of the whole or narrower ones, without a lower one of its own.
  // nullopt: `stop` returned true.
  std::optional<std::array<Part, 2>> split(const Part& part, Work& work, const Interrupted* stop);
  // Divides the part into cells, without lower functions of their own. nullopt: the overlay fails, the error would be
  // more than `most_cell_error` of the weight, or there would be more than `most_parts` parts.
  std::optional<CellParts> cells(const Part& part, std::uint64_t most_parts, Work& work);
  // Measures the corners of a rough part, which may lower its upper function. False: `stop` returned true.
  bool measure(Part& part, Work& work, const Interrupted* stop);
  // Whether more work can narrow the enclosure: rounding is not most of its width, nor all of the part.
  bool can_narrow(const Part& part) const;
  // The width that can_narrow() takes for rounding's.
  double floor_of(const Part& part) const { return 4 * (slack_high(part.depth) + slack_low(part.depth)); }
  // Whether rounding allows another cut.
  bool can_split(const Part& part) const;
  // How far a corner of a part may be from the exact point, with kMinorantSlack.
  double slack_low(std::uint32_t depth) const;

 private:
  double slack_high(std::uint32_t depth) const;
  Linear high_of(const Part& part, bool by_overlay, Work& work);
  bool is_within(Linear& high, double slack, const Part& part, Work& work);
  void tighten_by_overlay(const Part& part, Linear& high, Work& work);
  double add_cell(const Part& part, const PreparedTriangle& frame, const Overlay::Cell& cell, double whole,
                  CellParts& made) const;
  double add_fan(const Part& part, const PreparedTriangle& frame, const PreparedTriangle& over,
                 const Overlay::Cell& cell, double whole, CellParts& made) const;
  PartCut cut_of(const Part& part) const;
  std::optional<double> crease(const Corner& a, const Corner& b, double length) const;

  const Bvh& to_;
  const double error_;
  const std::vector<double> limits_;
  const double most_cell_error_;
  Overlay overlay_;
};

}  // namespace meshgauge
