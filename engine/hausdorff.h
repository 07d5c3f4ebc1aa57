// The face of the engine: bounds of the Hausdorff distance between two triangle meshes.
//
//   h(A,B) = max over a in A of min over b in B of |a-b|        one-sided
//   H(A,B) = max(h(A,B), h(B,A))                                symmetric
//
// measure() returns lower <= distance <= upper, certified: rounding included (docs/design.md, engine/rounding.h).
// The method is that of Zheng et al., "Economic Upper Bound Estimation in Hausdorff Distance Computation
// for Triangle Meshes", Computer Graphics Forum 2022 ("the paper").
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/statistics.h"

namespace meshgauge {

enum class Direction { symmetric, a_to_b, b_to_a };

// How a piece of the mesh is bounded from above; engine/bounds/ has one file each.
enum class Strategy {
  automatic,     // the default and the fastest: certificates, overlay and Lipschitz bounds, bisection
  four_point,    // the paper's: candidates are the owners of the points nearest to 3 corners and centroid
  n_point,       // the same with Options::points samples a piece
  triangle_set,  // Tang, Lee, Kim 2009: all triangles that can matter, found once for a triangle
};

// Stop rules (paper section 5.1); the first that holds ends the work. All in the meshes' unit.
struct Tolerance {
  std::optional<double> absolute;  // U - L <= absolute                 (eq. 14)
  std::optional<double> diagonal;  // U - L <= diagonal * Diag(A)       (eq. 15); Diag is always mesh a's
  std::optional<double> relative;  // U - L <= relative * L             (eq. 17)
};

struct Options {
  Direction direction = Direction::symmetric;
  Tolerance tolerance{std::nullopt, 1e-6, 0.01};
  std::optional<double> max_distance;  // the gate: stop as soon as U <= max_distance or L > max_distance
  Strategy strategy = Strategy::automatic;
  int points = 4;                                         // n_point only: 4, 10, 31, 109, 409 or 1585
  std::size_t max_memory_bytes = std::size_t{512} << 20;  // of the waiting pieces; when spent: Stop::budget
  std::uint64_t max_work_items = std::numeric_limits<std::uint64_t>::max();  // pieces split; when spent: Stop::budget
  unsigned threads = 1;                // of this job, at least 1; more than one for `automatic` only
  std::string_view simd = "auto";      // the instruction set: one of supported_simd(), or "auto" for the fastest
  std::optional<Sampling> statistics;  // sampled after the measurement, if there is time left
};

// The instruction sets of this processor, the fastest first; the last one is "scalar". They give the same bits.
std::span<const std::string_view> supported_simd();

// Whether `points` is one of the stencils of n_point.
bool is_stencil(int points);

enum class Stop {
  converged,        // a rule of Options::tolerance holds
  gate_decided,     // max_distance is decided
  timeout,          // the deadline came first
  cancelled,        // Control::cancel came first
  budget,           // a budget is spent: memory or work items
  precision_floor,  // the tolerance is below what rounding allows; the interval is as tight as it gets
};

enum class Rule { absolute, diagonal, relative };

struct Witness {
  Vec3 point_a = Vec3::Zero();   // on the mesh measured from; |point_a - point_b| is the distance attained
  std::uint32_t triangle_a = 0;  // 0-based index of the triangle that holds point_a
  Vec3 point_b = Vec3::Zero();   // on the mesh measured to: nearest to point_a
  std::uint32_t triangle_b = 0;
};

struct Bounds {
  double lower = 0;
  double upper = 0;
  std::optional<Witness> witness;  // none only when the work ended before any point was measured
};

struct Culling {
  std::size_t triangles = 0;  // of the mesh measured from
  std::size_t survivors = 0;  // triangles that the traversal could not cull
  double rate() const {
    return triangles ? 1.0 - static_cast<double>(survivors) / static_cast<double>(triangles) : 0.0;
  }
};

struct Work {
  std::uint64_t nearest_queries = 0;
  std::uint64_t cache_hits = 0;      // vertices whose nearest point was known already
  std::uint64_t triangle_tests = 0;  // point-triangle distances
  std::uint64_t subdivisions = 0;    // pieces split in the reduction
  std::uint32_t max_depth = 0;       // deepest subdivision
  std::size_t peak_heap = 0;         // most pieces waiting at once

  Work& operator+=(const Work& other);  // of two parts of one job
};

// One direction. In a symmetric measurement the second direction is followed only as far as it can
// raise the maximum, so its own interval is valid but may be wide.
struct Directed {
  Bounds bounds;
  Culling culling;
  Work work;
};

struct Timings {  // milliseconds of wall time
  double build = 0;
  double traverse = 0;
  double reduce = 0;
  double certify = 0;
  double statistics = 0;
};

struct Outcome {
  Stop stop = Stop::converged;
  std::optional<Rule> met_by;  // the rule that holds, when one does (also when the stop was another)
  double lower = 0;            // of the direction asked for
  double upper = 0;
  std::optional<Directed> a_to_b;
  std::optional<Directed> b_to_a;  // witness.point_a lies on mesh b here: always "the mesh measured from"
  double precision_floor = 0;      // width of the interval that rounding alone can cause, in the meshes' unit
  double diagonal_a = 0;
  std::string_view simd;  // the instruction set that was used
  unsigned threads = 1;   // at most this many were
  Timings timings;
  std::optional<Statistics> statistics;  // when they were asked for; nothing above depends on them, or is lost by them
};

// Precondition: both meshes pass validate(), is_stencil(options.points) for n_point, options.simd is supported. Out of
// time, budget or patience it returns the interval reached; std::bad_alloc is all it throws. With one thread
// deterministic: same input and options, same bits, unless interrupted, whatever the instruction set. With more the
// interval may differ within what was asked for, never a verdict that was given. Statistics are the same with any
// number.
Outcome measure(MeshView a, MeshView b, const Options& options, Control& control);

const char* version();  // of the engine, "0.2.0"

}  // namespace meshgauge
