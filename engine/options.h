// The options of a measurement.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine/area.h"
#include "engine/region.h"
#include "engine/sides.h"
#include "engine/statistics.h"
#include "engine/thresholds.h"

namespace meshgauge {

enum class Direction { symmetric, a_to_b, b_to_a };

// The method that bounds the distance of a piece of the mesh from above: the paper's are in engine/paper.
enum class Strategy {
  automatic,     // the default and the fastest: certificates, overlay and Lipschitz bounds, bisection
  four_point,    // the paper's: tries the triangles that hold the points nearest to the 3 corners and the centroid
  n_point,       // as four_point, with Options::points samples for each piece
  triangle_set,  // Tang, Lee, Kim 2009: collects all triangles of B that can matter, once for each triangle of A
};

// Stop rules (paper, section 5.1) for the lower bound L and the upper bound U: the first that holds ends the work.
// nullopt: the rule does not apply.
struct Tolerance {
  std::optional<double> absolute;  // U - L <= absolute, in the meshes' unit (eq. 14)
  std::optional<double> diagonal;  // U - L <= diagonal * Outcome::diagonal_a (eq. 15), in both directions
  std::optional<double> relative;  // U - L <= relative * L (eq. 17)
};

// A limit plus a change, rounded down or up: exact where it is a double.
inline double changed_limit(double limit, double change, double towards) {
  const double sum = limit + change, part = sum - limit;
  const double off = (limit - (sum - part)) + (change - part);  // exactly limit + change - sum (Knuth)
  const bool is_beyond = towards < 0 ? off < 0 : off > 0;
  return is_beyond ? std::nextafter(sum, towards) : sum;
}

// What an uncertainty leaves of a limit, rounded away from it: what is at most `pass` passes, what is above `fail`
// fails. Without an uncertainty both are the limit.
struct LimitEnds {
  double pass = 0;
  double fail = 0;

  bool are_apart() const { return pass < fail; }
};
inline LimitEnds ends_of(double limit, double uncertainty) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {changed_limit(limit, -uncertainty, -kInfinity), changed_limit(limit, uncertainty, kInfinity)};
}

struct Options {
  Direction direction = Direction::symmetric;
  Tolerance tolerance{std::nullopt, 1e-6, 0.01};
  std::optional<double>
      max_distance;  // the gate, in the meshes' unit: stop when U <= it or L > it; with regions: the rest's
  // For a measured distance, in the meshes' unit: the gate is decided when U <= max_distance - uncertainty, or
  // L > max_distance + uncertainty, or neither will ever hold.
  double uncertainty = 0;
  // Once the gate is decided: search on for at most 0.5 s, until U - L <= L / 100, or max_distance / 10,000, or a rule
  // holds; a share with a max_share likewise. The verdict does not change. Without an interruption of this search the
  // bits depend on the input alone.
  bool narrow = false;
  Strategy strategy = Strategy::automatic;
  int points = 4;                                         // samples of n_point: 4, 10, 31, 109, 409 or 1585
  std::size_t max_memory_bytes = std::size_t{512} << 20;  // for waiting pieces; beyond it: Stop::budget
  std::uint64_t max_work_items = std::numeric_limits<std::uint64_t>::max();  // pieces split; then: Stop::budget
  unsigned threads = 1;              // at least 1; only `automatic` uses more than one
  std::string_view simd = "auto";    // instruction set: "auto" for the fastest, or one of supported_simd()
  std::optional<AreaOptions> areas;  // nullopt: none; else bounded after the interval is final
  // nullopt: none; else bounded after the areas. Precondition: a direction that measures from mesh a.
  std::optional<SideOptions> sides;
  std::optional<Sampling> statistics;  // nullopt: none; else sampled after all that is certified
  // Not empty: each region is measured by itself, then what is in no region, the rest (engine/measure/region_stage.h).
  std::vector<Region> regions;
  Thresholds thresholds;  // for tests

  LimitEnds ends(double limit) const { return ends_of(limit, uncertainty); }
};

// The instruction sets that this processor supports, the fastest first; the last is "scalar". All give the same bits.
std::span<const std::string_view> supported_simd();

// Whether n_point supports this number of samples.
bool is_stencil(int points);

}  // namespace meshgauge
