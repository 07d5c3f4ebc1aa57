// The search for the intervals of engine/area.h, in one direction: from mesh A to mesh B, in the unit frame.
//
//  1. If shares alone are asked for, the triangles of A that are within every limit, or beyond every one, are closed at
//     once: places.h.
//  2. The distance of each vertex of the others, then an upper function for each triangle (part.h). What the questions
//     need no more of is closed.
//  3. Where lengths are asked for and the surface is large, foresight: a sample of the triangles is searched first. The
//     least contribution that was worth refining there is what is refined everywhere, triangle by triangle in step 2;
//     parts below it are closed, so that few have to be kept.
//  4. Rounds (area_rounds.cpp). Each sums up all parts, and ends the search when every interval is narrow enough.
//     Otherwise the parts that contribute most to the widths get a lower function, or are divided into cells or cut.
//
// The intervals hold after each round, and after each of the sums that foresight makes meanwhile. An interruption
// leaves those of the last sum. Threads share out the parts of a round, and results are taken over in the order of the
// parts: the same bits for any number of threads, except that the sweep of step 1 may leave out other triangles. A
// sample is a guess of what is worth the work: no interval depends on its being a good one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/area.h"
#include "engine/control.h"
#include "engine/extras/area/enclosure.h"
#include "engine/extras/area/part.h"
#include "engine/extras/area/totals.h"
#include "engine/mesh/large_array.h"
#include "engine/options.h"
#include "engine/search/piece.h"
#include "engine/thread_pool.h"
#include "engine/tree/ordered_mesh.h"

namespace meshgauge {

// The input of one direction. Lengths in frame units.
struct AreaDirection {
  const OrderedMesh& from;
  const OrderedMesh& to_mesh;
  const Bvh& to;               // over to_mesh
  const Adjacency& adjacency;  // of to_mesh
  const Frame& frame;
  const Options& options;         // areas, max_memory_bytes, max_work_items, thresholds
  double most;                    // upper bound of the distance of every point of `from`
  double upper;                   // the same in the meshes' unit
  double error;                   // as in PartBounder
  std::span<const float> bounds;  // MeasuredDirection::bounds
  ThreadPool& pool;
  Control& control;                   // polled every few milliseconds
  const std::function<void()>& tell;  // called between rounds, to report progress
};

// Measures the vertices of the triangles in `rest`, ascending; nullopt: of all. The others keep Corner(). The result
// does not depend on the threads. False: interrupted.
bool measure_vertices(const AreaDirection& direction, const std::optional<std::vector<std::uint32_t>>& rest,
                      LargeArray<Corner>& corners);

// The tasks that `count` items make, `each` a task.
inline std::size_t tasks_for(std::size_t count, std::size_t each) { return (count + each - 1) / each; }

// What is still too wide of the intervals: the scales that turn a part's widths into tolerances; 0: narrow enough.
struct Demand {
  // The share beyond a limit of distance.
  struct Probe {
    double down, up;
    double scale;
  };
  std::vector<Probe> probes;
  double mean = 0;
  double square = 0;
  double excess = 0;  // of the widest interval: its width, less a tolerance, in tolerances

  bool met() const { return probes.empty() && mean == 0 && square == 0; }

  // Whether a lower function, which is at most the corners' distances, can narrow the part, or show that nothing can.
  // `near`: the slack of its functions, within which a distance may equal a limit.
  bool needs_low(const Part& part, double near) const {
    double farthest = 0;
    for (const Corner& corner : part.corners) farthest = std::max(farthest, corner.distance);
    return mean > 0 || square > 0 ||
           std::any_of(probes.begin(), probes.end(), [&](const Probe& probe) { return farthest + near > probe.up; });
  }

  // The largest of the part's widths in tolerances, times its weight.
  double contribution(const Part& part) const {
    const Enclosure& e = part.enclosure;
    double most_wanted = 0;
    for (const Probe& probe : probes) {
      const double high = share_beyond(e.high, probe.down);
      if (high > 0) most_wanted = std::max(most_wanted, probe.scale * (high - share_beyond(e.low, probe.up)));
    }
    if (mean > 0) most_wanted = std::max(most_wanted, mean * mean_width(e));
    if (square > 0) most_wanted = std::max(most_wanted, square * square_width(e));
    return part.weight * most_wanted;
  }
};

class AreaSearch {
 public:
  explicit AreaSearch(const AreaDirection& direction);

  // Lengths of the result in the meshes' unit.
  AreaBounds run();

 private:
  struct Limit {
    double down, up;
  };
  struct Refined;
  // What is worth refining: what contributes at least `least`.
  struct Foresight {
    Demand demand;
    double least;
  };
  // What comes of some triangles.
  struct Bounded {
    std::vector<Part> parts;
    double cell_error = 0;
    Work work;
  };
  static constexpr std::size_t kPartsASum = std::size_t{1} << 12;  // a task of a pass over all parts

  bool are_shares_alone() const { return !asked_.mean && asked_.quantiles.empty(); }
  bool weigh();
  bool leave_out_decided();
  std::optional<AreaStop> bound_triangles();
  bool take_triangle(PartBounder& bounder, std::size_t triangle, std::uint64_t most_parts, Bounded& found);
  bool refine_triangle(PartBounder& bounder, const Part& whole, std::uint64_t most_parts, Bounded& found);
  void take_over(const Bounded& found);
  bool foresee();
  std::optional<Foresight> searched(const AreaDirection& direction, const std::vector<std::uint32_t>& sample,
                                    const std::optional<Foresight>& foresight);
  void forget();
  AreaStop bound_and_refine();
  std::size_t to_visit() const { return rest_ ? rest_->size() : in_.from.triangles.size(); }
  std::size_t visited(std::size_t i) const { return rest_ ? (*rest_)[i] : i; }
  AreaStop narrow();
  AreaStop refine_all();
  void narrow_decided();
  bool update();
  bool update_quantiles();
  // `of_all`: also of what is narrow enough.
  Demand demand(bool of_all = false) const;
  void demand_quantile(const AreaInterval& known, Demand& demand) const;
  double tolerance_of(double length) const;
  double tolerance_of_share(std::size_t k) const;
  bool is_narrow(std::size_t k) const;
  bool is_closed(const Part& part) const;
  void close(const Part& part);
  bool close_unvisited(std::size_t begin);
  template <class Add>
  bool add_all(std::size_t count, const Add& add, std::vector<ShareSum>& shares, MeanSum& means);
  void add(const Enclosure& enclosure, double weight, std::vector<ShareSum>& shares, MeanSum& means) const;
  std::array<Corner, 3> corners_of(std::size_t triangle) const {
    const Triangle& t = in_.from.triangles[triangle];
    return {corners_[t[0]], corners_[t[1]], corners_[t[2]]};
  }
  bool update_sums(std::size_t begin);
  TotalArea area_of_all() const;
  bool sort_out(const Demand& demand, std::vector<double>& wanted);
  std::vector<std::uint32_t> choose(const Demand& demand);
  bool refine(const std::vector<std::uint32_t>& chosen, const Demand& demand);
  bool refine_some(std::span<const std::uint32_t> chosen, const Demand& demand);
  bool refine_part(PartBounder& bounder, const Foresight& aim, std::uint64_t most_parts, Work& work, Refined& refined);
  bool bound_cells(PartBounder& bounder, const Foresight& aim, CellParts& cells, Work& work);
  double most_needed(const Part& part) const;
  static bool is_worth_measuring(const Part& part);
  bool is_worth_cells(const Part& part) const;
  std::size_t most_at_once() const;
  bool over_budget() const;
  AreaStop interrupted() const;
  AreaBounds result(AreaStop stop) const;

  const AreaDirection in_;
  const AreaOptions& asked_;
  std::deque<PartBounder> bounders_;  // one for each thread
  const AreaWeights weights_;
  const Interrupted stop_;
  std::vector<Limit> limits_;                       // AreaOptions::beyond in frame units
  std::optional<std::vector<std::uint32_t>> rest_;  // the triangles of A to visit, ascending; nullopt: all
  LargeArray<Corner> corners_;                      // by vertex of A
  TotalArea area_;

  std::deque<Part> open_;                 // deques: a vector would hold three copies while it grows
  std::deque<WeightedEnclosure> closed_;  // kept for quantiles only
  std::vector<ShareSum> closed_shares_;
  MeanSum closed_means_;

  AreaBounds known_;                    // in frame units: the intersection of all intervals so far
  std::optional<Foresight> foresight_;  // from a sample of the triangles
  double closed_early_ = 0;             // contribution of what was closed by foresight
  int forgotten_ = 0;                   // how often it began anew
  std::size_t refined_ = 0;             // parts that were chosen so far
  double least_chosen_ = 0;             // contribution of the parts that choose() takes
  bool is_narrowing_ = false;           // all gates are decided; their shares are narrowed
  Work work_;
};

}  // namespace meshgauge
