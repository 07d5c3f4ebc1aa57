// The search for the intervals of engine/sides.h, in the unit frame. B is closed and oriented.
//
//  1. With a gate, the triangles of A that are within both limits are left out: places.h.
//  2. The distance of each vertex of the others. The sides of the farthest ones give the first lower bounds.
//  3. An upper function for each triangle (part.h). What cannot exceed what is asked of the sides that it may lie on is
//     closed.
//  4. Rounds. The parts with the largest upper bounds get a lower function. Where it is above 0 one ray tells the side,
//     which bounds the part's distance on the other one. Then they are cut.
//
// The intervals hold after each round. Threads share out the parts of a round, and results are taken over in the order
// of the parts: the same bits for any number of threads, except for what the sweep of step 1 leaves out.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "engine/extras/area/area_search.h"
#include "engine/extras/area/part.h"
#include "engine/options.h"
#include "engine/sides.h"

namespace meshgauge {

// Sides, as indices.
inline constexpr std::size_t kOutside = 0;
inline constexpr std::size_t kInside = 1;

// A part of A.
//
// Statement. Let low <= d(.,B) <= high be the linear functions of the part. Then all of its points where low > 0 are on
// one side of B, and the others are at most as far from B as the largest value of high where low <= 0.
// Proof. Where low > 0 the part does not meet B, and that set is convex: a half-plane within a triangle.
struct SidePart {
  Part part;
  std::array<double, 2> upper{};    // of the distance of the points on each side
  std::optional<std::size_t> side;  // of its points where low > 0, or those of the part that it was cut from
  std::uint32_t triangle = 0;
  bool is_at_floor = false;  // rounding allows no narrower bounds
};

class SideSearch {
 public:
  // `direction.options`: max_memory_bytes, max_work_items, thresholds, and the ends of a gate's limits.
  SideSearch(const AreaDirection& direction, const SideOptions& asked);

  // Lengths and points of the result in the meshes' unit; triangles are those of `from`.
  SideOutcome run();

 private:
  // A point of A on one side. Frame units.
  struct Reached {
    double lower = 0;
    Vec3 at = Vec3::Zero();
    std::uint32_t triangle = 0;
  };
  // What is learnt from one part.
  struct Learnt {
    std::array<std::optional<Reached>, 2> reached;
    std::optional<Vec3> turned;  // a point that B winds around in the wrong direction
    bool stopped = false;
  };
  struct Refined {
    SidePart first, second;
    bool is_split = false;
    Learnt learnt;
  };

  AreaStop search();
  bool leave_out_within();
  void seed();
  std::optional<AreaStop> bound_triangles();
  AreaStop refine_all();
  std::vector<std::size_t> choose();
  bool refine(const std::vector<std::size_t>& chosen);
  void refine_one(PartBounder& bounder, Refined& refined, Work& work) const;
  void find_side(PartBounder& bounder, SidePart& part, Learnt& learnt, Work& work) const;
  std::optional<std::size_t> side_of(const Vec3& point, Learnt& learnt, Work& work) const;
  void reach(const Corner& corner, double slack, std::uint32_t triangle, Learnt& learnt, Work& work) const;
  void take(const Learnt& learnt);
  bool is_decided() const;
  double goal(std::size_t side) const;
  double excess(const SidePart& part) const;
  void close(const std::array<double, 2>& upper);
  void keep(SidePart&& part);
  bool over_budget() const;
  AreaStop interrupted() const;
  SideOutcome result(AreaStop stop) const;

  const AreaDirection in_;
  const SideOptions asked_;
  std::deque<PartBounder> bounders_;  // one for each thread
  const Interrupted stop_;
  std::optional<std::array<LimitEnds, 2>> limits_;  // by side
  std::optional<std::vector<std::uint32_t>> rest_;  // the triangles of A to visit, ascending; nullopt: all
  LargeArray<Corner> corners_;                      // by vertex of A
  std::deque<SidePart> open_;
  std::array<double, 2> closed_{};  // upper bounds of the parts that are closed, by side
  std::array<Reached, 2> reached_;
  std::optional<Vec3> turned_;
  bool is_covered_ = false;  // whether open_ and closed_ cover all of A
  bool at_floor_ = false;    // rounding closed a part that is above what is asked
  std::uint64_t pieces_ = 0;
  Work work_;
};

// Searches as asked. A gate is decided first, and narrowed without its limits.
SideOutcome search_sides(const AreaDirection& direction, const SideOptions& asked);

}  // namespace meshgauge
