// The parts of A that the area search bounds: triangles of A, and what cuts from a corner to the opposite edge make of
// them. A cut at a + s (b - a) divides the exact part's area as s : 1 - s, exactly, so weights are divided alike
// (rounding.h R12).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "engine/area/enclosure.h"
#include "engine/bounds/overlay.h"
#include "engine/bounds/piece.h"
#include "engine/bvh.h"

namespace meshgauge {

struct Part {
  std::array<Corner, 3> corners;
  Enclosure enclosure;
  double weight = 0;  // of its area: AreaWeights
  std::uint32_t depth = 0;
  bool has_low = false;  // enclosure.low is that of its own linear_minorant() or better
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
  // frame units.
  PartBounder(const Bvh& to, const Adjacency& adjacency, double error)
      : to_(to), error_(error), overlay_(to, adjacency) {}

  // A whole triangle with measured corners; its enclosure has an upper function and no lower one.
  Part whole(const std::array<Corner, 3>& corners, double weight, Work& work);
  // Adds a lower function. False: `stop` returned true; the part is unchanged.
  bool bound_below(Part& part, Work& work, const Interrupted* stop);
  // Cuts the part in two, each with the functions of the whole or narrower ones, without a lower one of its own.
  // nullopt: `stop` returned true.
  std::optional<std::array<Part, 2>> split(const Part& part, Work& work, const Interrupted* stop);
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
  Linear high_of(const Part& part, Work& work);
  void tighten_by_overlay(const Part& part, Linear& high, Work& work);
  PartCut cut_of(const Part& part) const;
  std::optional<double> crease(const Corner& a, const Corner& b, double length) const;

  const Bvh& to_;
  const double error_;
  Overlay overlay_;
};

}  // namespace meshgauge
