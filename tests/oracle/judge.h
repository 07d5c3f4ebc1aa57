// Checks the engine's outcome for a pair of meshes by exact arithmetic.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/hausdorff.h"
#include "oracle/farthest.h"

namespace meshgauge::oracle {

struct Violation {
  std::string check;   // short name of the check that failed
  std::string detail;  // the numbers, for a message
};

// What was done to a measurement from outside, which explains its stop reason.
struct Circumstances {
  bool deadline = false;
  bool cancelled = false;
  bool budget = false;
};

struct Effort {
  std::size_t max_points = 400;  // of the search for farthest points, in each direction
  std::size_t max_splits = 0;    // of the exact bracket, in each direction; 0: no bracket
};

// One pair of valid meshes. Distances found for one outcome are reused for the next.
class Judge {
 public:
  Judge(const Mesh& a, const Mesh& b, const Effort& effort);

  // Checks, each by name:
  //   finite, order     0 <= lower <= upper, finite, of the outcome and of each direction; no NaN anywhere
  //   combine           the outcome is the maximum of the directions asked for
  //   lower             d(w,B) - d(w,A) >= lower for the witness w, and d(w,B) >= lower
  //   upper             no sample of the mesh measured from is farther than upper
  //   bracket           the exact bracket and the interval meet
  //   witness           indices in range; both points on their triangles and |w - point_b| = d(w,B), within rounding
  //   rule, stop        exactly a rule that holds is reported; the stop reason is one that happened
  //   floor             precision_floor is reported only for intervals that narrow, and only below it
  //   diagonal, culling
  std::optional<Violation> judge(const Options& options, const Outcome& outcome, const Circumstances& circumstances);

  // The largest exact squared distance seen in the direction asked for: h is at least its root.
  Ratio largest_seen_sq(Direction direction);

  // The largest distance by which rounding may move a reported point.
  double point_tolerance() const { return point_tolerance_; }

 private:
  // One direction: from -> to.
  struct Side {
    const Mesh* from = nullptr;
    const Mesh* to = nullptr;
    Surface from_surface, to_surface;
    std::optional<Farthest> farthest;
    std::optional<Bracket> bracket;
    struct Known {
      Vec3 point;
      Ratio distance_sq;
    };
    std::vector<Known> known;  // distances to `to` of witnesses
  };

  Side& side(Direction direction) { return sides_[direction == Direction::b_to_a ? 1 : 0]; }
  const Farthest& farthest(Side& side);
  const Bracket& bracket(Side& side);
  static const Ratio& distance_to_sq(Side& side, const Vec3& point);

  std::optional<Violation> judge_directed(Side& side, const Directed& directed);
  std::optional<Violation> judge_upper(Side& side, const Bounds& bounds);
  std::optional<Violation> judge_witness(Side& side, const Bounds& bounds, const Witness& witness) const;
  std::optional<Violation> judge_points(Side& side, const Witness& witness) const;

  Effort effort_;
  std::array<Side, 2> sides_;
  double point_tolerance_ = 0;
};

}  // namespace meshgauge::oracle
