// What a measurement gives: bounds, why it ended, and what it took.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "engine/mesh.h"
#include "engine/statistics.h"

namespace meshgauge {

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

}  // namespace meshgauge
