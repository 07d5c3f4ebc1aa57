// Weights of the parts of A, sums over them, and the certified intervals and quantiles that follow from these.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "engine/area.h"
#include "engine/control.h"
#include "engine/extras/area/enclosure.h"
#include "engine/extras/area/part.h"
#include "engine/mesh.h"
#include "engine/tree/ordered_mesh.h"

namespace meshgauge {

// The areas of A's triangles, as weights with an error. Weights are in a unit of their own, about the square of the
// mesh's width. The area of a triangle lies between its weight and its weight + error: rounding.h R13.
class AreaWeights {
 public:
  struct Weight {
    double weight = 0;
    double error = 0;
  };

  // `error`: as in PartBounder.
  AreaWeights(const OrderedMesh& mesh, double error);

  Weight of(std::size_t triangle) const;

 private:
  MeshView mesh_;
  double scale_;  // a power of two
  double moved_;  // how far an edge's end may be moved, in scaled units
};

// An enclosure with the weight of its part.
struct WeightedEnclosure {
  Enclosure enclosure;
  double weight = 0;
};

// Bounds of a sum of weight * share over all parts, and whether every single share is 0, or 1.
struct ShareSum {
  double low = 0;
  double high = 0;
  bool all_zero = true;  // of high: exactly nothing of the surface is beyond
  bool all_one = true;   // of low: exactly all of it is

  // The limit is [down, up]: the exact one, unless scaling to the frame has rounded it.
  void add(const Enclosure& enclosure, double weight, double down, double up) {
    const double above = share_beyond(enclosure.high, down);
    all_zero = all_zero && most(enclosure.high) <= down;
    all_one = all_one && least(enclosure.low) > up;
    high += weight * above;
    if (above > 0) low += weight * share_beyond(enclosure.low, up);
  }

  ShareSum& operator+=(const ShareSum& other) {
    low += other.low, high += other.high;
    all_zero = all_zero && other.all_zero;
    all_one = all_one && other.all_one;
    return *this;
  }
};

struct MeanSum {
  double low = 0;
  double high = 0;
  double square_low = 0;
  double square_high = 0;

  void add(const Enclosure& enclosure, double weight) {
    high += weight * mean(enclosure.high);
    square_high += weight * mean_square(enclosure.high);
    low += weight * mean_below(enclosure.low);
    square_low += weight * mean_square_below(enclosure.low);
  }

  MeanSum& operator+=(const MeanSum& other) {
    low += other.low, high += other.high;
    square_low += other.square_low, square_high += other.square_high;
    return *this;
  }
};

// The area of A: between `weight` and `weight + error`, up to the rounding of the sum of `terms` weights. `terms` also
// counts the parts, so that sums over them have the same relative error.
struct TotalArea {
  double weight = 0;
  double error = 0;
  double cell_error = 0;  // the sum of CellParts::error
  std::size_t terms = 0;

  bool none() const { return !(weight > 0); }
  // Certified intervals. `most`: an upper bound of the distance of every point.
  AreaInterval share(const ShareSum& sum) const;
  AreaInterval mean(const MeanSum& sum, double most) const;
  AreaInterval rms(const MeanSum& sum, double most) const;

 private:
  AreaInterval average(double low, double high, double most) const;
};

// All parts of A.
struct AllParts {
  const std::deque<WeightedEnclosure>& closed;
  const std::deque<Part>& open;
};

// Returns an interval within `known`, a certified interval of it, that holds the smallest distance that the share p of
// the area is within. Its ends are sought to `resolution`. nullopt: `stop` returned true.
//
// Statement. Let S(t) be the share of the area beyond t. If S(t) <= 1 - p, the quantile is at most t; if S(t) > 1 - p,
// it is at least t. So each t with a certified bound of S(t) on one side of 1 - p gives an end.
std::optional<AreaInterval> quantile(double p, const TotalArea& area, const AllParts& parts, const AreaInterval& known,
                                     double resolution, const Interrupted& stop);

}  // namespace meshgauge
