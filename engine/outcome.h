// The result of a measurement: bounds, the reason for its end, and its cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/area.h"
#include "engine/mesh.h"
#include "engine/sides.h"
#include "engine/statistics.h"

namespace meshgauge {

// Why a measurement ended. The interval holds in every case.
enum class Stop {
  converged,        // a rule of Options::tolerance holds
  gate_decided,     // upper <= max_distance or lower > max_distance
  timeout,          // the deadline passed
  cancelled,        // Control::cancel() was called
  budget,           // max_memory_bytes or max_work_items was reached
  precision_floor,  // the tolerance is below what rounding allows; the interval is as tight as it gets
};

// The rules of Tolerance.
enum class Rule { absolute, diagonal, relative };

// A point of the mesh measured from whose exact distance to the other mesh is at least Bounds::lower. In the meshes'
// unit; point_a lies on its mesh up to rounding, and so does point_b.
struct Witness {
  Vec3 point_a = Vec3::Zero();   // on the mesh measured from
  std::uint32_t triangle_a = 0;  // 0-based index of the triangle that holds point_a
  Vec3 point_b = Vec3::Zero();   // on the mesh measured to: nearest to point_a
  std::uint32_t triangle_b = 0;  // 0-based index of the triangle that holds point_b
};

// lower <= distance <= upper, certified; in the meshes' unit.
struct Bounds {
  double lower = 0;
  double upper = 0;
  std::optional<Witness> witness;  // nullopt: the work ended before a point was measured
};

struct Culling {
  std::size_t triangles = 0;  // of the mesh measured from; with regions, of its parts
  std::size_t survivors = 0;  // triangles that the traversal could not cull
  // The culling rate: the share of the triangles that did not survive, from 0 to 1.
  double rate() const {
    return triangles ? 1.0 - static_cast<double>(survivors) / static_cast<double>(triangles) : 0.0;
  }
};

// Counters of one direction.
struct Work {
  std::uint64_t nearest_queries = 0;
  std::uint64_t cache_hits = 0;      // points that had been measured already
  std::uint64_t triangle_tests = 0;  // point-triangle distances computed
  std::uint64_t subdivisions = 0;    // pieces split in the reduction
  std::uint32_t max_depth = 0;       // largest number of subdivisions on the way from a triangle to a piece
  std::size_t peak_heap = 0;         // largest number of pieces that waited at once

  // Adds the counters of another part of the same job; of max_depth and peak_heap it keeps the maximum.
  Work& operator+=(const Work& other);
};

// The result of one direction. A symmetric measurement follows the second direction only as far as it can raise the
// maximum: that direction's interval holds, but may be wide.
struct Directed {
  Bounds bounds;
  Culling culling;
  Work work;
};

// What was measured of a region, or of the rest: the largest distance of its points, to all of the other mesh.
struct RegionOutcome {
  bool empty = true;  // no point of a mesh that was measured from lies in it; then the distance is 0
  Stop stop = Stop::converged;
  double lower = 0;  // bounds of the distance, of the directions asked for, in the meshes' unit
  double upper = 0;
  std::optional<Bounds> a_to_b;  // nullopt: not asked for, or a group
  std::optional<Bounds> b_to_a;
  double precision_floor = 0;  // what rounding, and cutting the surface at a sphere, adds to the width of the interval
};

// Wall time of each stage, in milliseconds.
struct Timings {
  double build = 0;
  double traverse = 0;
  double reduce = 0;
  double certify = 0;
  double areas = 0;  // and sides
  double statistics = 0;
};

struct Outcome {
  Stop stop = Stop::converged;
  std::optional<Rule> met_by;  // the rule that holds; nullopt: `stop` is not `converged`
  double lower = 0;            // bounds of the distance asked for, in the meshes' unit
  double upper = 0;
  std::optional<Directed> a_to_b;  // nullopt: not asked for
  std::optional<Directed> b_to_a;  // nullopt: not asked for; its witness.point_a lies on mesh b, the mesh measured from
  double precision_floor = 0;      // width of the interval that rounding alone can cause, in the meshes' unit
  double diagonal_a = 0;           // length of the diagonal of mesh a's bounding box, in its unit
  std::string_view simd;           // the instruction set that was used
  unsigned threads = 1;            // upper limit of the threads that were used
  Timings timings;
  std::vector<RegionOutcome> regions;    // of Options::regions, in their order, then of the rest; empty: not asked for
  std::optional<AreaOutcome> areas;      // nullopt: not asked for; no bound above depends on them
  std::optional<SideOutcome> sides;      // nullopt: not asked for; the same
  std::optional<Statistics> statistics;  // nullopt: not asked for; nothing above depends on them
};

}  // namespace meshgauge
