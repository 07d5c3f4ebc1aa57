// The state of one direction of a measurement while it runs: from mesh A to mesh B, in the unit frame.
//
// lower() <= (up to slack) h(A,B) <= upper() + slack holds at every moment between two calls, but for what Workers have
// not handed in yet.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "engine/adjacency.h"
#include "engine/bounds/piece.h"
#include "engine/options.h"
#include "engine/outcome.h"
#include "engine/rounding.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Where the largest distance so far was seen. Frame coordinates.
struct Candidate {
  Vec3 point = Vec3::Zero();
  double distance = -1;  // computed
  std::uint32_t triangle = 0;
  bool is_vertex = true;  // of A, hence exactly on A
};

// Every point of the box is within this of b (eq. 4/5 for any point b of B).
inline double farthest_of_box(const Box& box, const Vec3& b) {
  return (b - box.low).cwiseAbs().cwiseMax((box.high - b).cwiseAbs()).norm();
}

// When a search may end. All in frame units; `slack` is what certifying will cost the interval.
struct Goal {
  double width = 0;     // the absolute and the diagonal rule: upper - lower <= width
  double relative = 0;  // the relative rule
  std::optional<double> gate;

  // The computed gap upper - lower at which a rule will hold after certifying; never below rounding::kSmallestGap.
  double gap(double lower, double slack) const;
};

class Search;
class SearchWorker;

// Looks at a search after each of its steps: the clock, the caller's patience, the gate.
class Monitor {
 public:
  Monitor() = default;
  Monitor(const Monitor&) = delete;
  Monitor& operator=(const Monitor&) = delete;
  virtual ~Monitor() = default;
  // Between two steps, when the search's bounds hold: a reason to stop now, if there is one.
  virtual std::optional<Stop> pulse(const Search& search) = 0;
  // In the middle of a step, on any thread: whether the next pulse will tell to stop. Nobody looks at the bounds.
  virtual bool interrupted() = 0;
};

class Search {
 public:
  // Measures one vertex of A, so that there is a candidate from the start. `from_box` is A's. `start_lower`: distances
  // up to this are of no interest (the other direction has reached it already).
  Search(MeshView from, const Box& from_box, const Bvh& to, const Goal& goal, double start_lower, Monitor& monitor,
         ThreadPool& pool);

  MeshView from() const { return from_; }
  const Box& from_box() const { return from_box_; }
  const Bvh& to() const { return to_; }
  ThreadPool& pool() const { return pool_; }
  std::optional<Stop> pulse() { return monitor_.pulse(*this); }
  bool interrupted() const { return monitor_.interrupted(); }
  Work& work() { return work_; }
  const Work& work() const { return work_; }
  // Triangles of A that the traversal could not cull.
  std::size_t& survivors() { return survivors_; }
  std::size_t survivors() const { return survivors_; }
  const Goal& goal() const { return goal_; }

  double lower() const { return lower_.load(std::memory_order_relaxed); }
  double upper() const;
  const Candidate& candidate() const { return candidate_; }

  // What certifying will take from the lower and add to the upper bound, as far as is known now.
  double lower_slack() const;
  double upper_slack() const;
  double slack() const { return lower_slack() + upper_slack() + output_rounding_; }
  // How far the reported witness may lie from the computed one, because the file's own frame is coarser.
  void set_witness_rounding(double rounding) { witness_rounding_ = rounding; }
  // What certifying takes from the lower bound that the search started with: the other direction's witness may cost
  // more.
  void set_start_slack(double slack) { start_slack_ = slack; }
  // What scaling both bounds back to the file's unit, outwards, costs: nothing unless the results are subnormal.
  void set_output_rounding(double rounding) { output_rounding_ = rounding; }

  // A number that is known to be a (computed) distance attained, here or in another worker: any thread may say so,
  // before its candidate is handed in.
  void raise_lower(double distance) {
    double known = lower();
    while (distance > known && !lower_.compare_exchange_weak(known, distance, std::memory_order_relaxed)) {
    }
  }
  // A sample of A at distance `corner.distance` from B.
  void observe(const Corner& corner, std::uint32_t triangle, bool is_vertex);

  // Pieces and nodes with upper bounds at or below this need not be followed.
  double cull_below() const { return cull_below(lower()); }
  // The same for strategy `auto`, which stops following what is within the tolerance already. With more slack than is
  // known now, because it may grow after something was dropped. Any thread may ask.
  double cull_within_tolerance() const { return cull_within_tolerance(lower()); }
  // If `lower` were the lower bound. Depends on nothing else that changes.
  double cull_within_tolerance(double lower) const {
    return std::max(cull_below(lower), lower + goal_.gap(lower, slack_to_come()));
  }
  // Forgets a piece; its bound stays in upper().
  void drop(double upper) { dropped_ = std::max(dropped_, upper); }
  // The gap between the computed bounds that the search does not resolve any further.
  double unresolved_gap() const { return std::max(rounding::kSmallestGap, unresolved_ - lower()); }

  // The pieces that wait for reduction: a max-heap by upper bound, or a stack once depth_first() was called.
  void push(const Piece& piece);
  Piece pop();
  bool empty() const { return waiting_.empty(); }
  std::size_t waiting() const { return waiting_.size(); }
  void depth_first() { is_heap_ = false; }
  // Drops the pieces whose bounds are at most `limit`; a heap stays a heap.
  void keep_above(double limit);

  // Memory for waiting pieces, and pieces split, from which on pulses should end the search. `others_bytes` is what a
  // strategy keeps besides.
  void set_budget(const Options& options) { budget_ = &options; }
  bool over_budget(std::size_t others_bytes = 0) const;
  std::uint64_t work_items_left() const {
    return budget_ ? budget_->max_work_items - std::min(budget_->max_work_items, work_.subdivisions)
                   : std::numeric_limits<std::uint64_t>::max();
  }

  // Bound of what has not been looked at yet: the first phase sets it, to 0 when it is through.
  void set_unvisited(double upper) { unvisited_ = upper; }

  // That of B, from the moment on when it was worth its time; null before.
  const Adjacency* adjacency() const { return adjacency_; }
  // Gets it from `source`, which gives null when it was interrupted. False: then.
  bool take_adjacency();
  void set_adjacency_source(std::function<const Adjacency*()> source) { adjacency_source_ = std::move(source); }

  // Takes over what a worker has found, and leaves it empty.
  void absorb(SearchWorker& worker);

  // No rule needs more work.
  bool reached_goal() const;
  // The computed lower bound is above the gate by more than any slack: worth certifying.
  bool above_gate() const { return goal_.gate && lower() - lower_slack() > *goal_.gate; }

 private:
  double cull_below(double lower) const;
  double lower_slack(bool interior) const;
  double slack_to_come() const;

  MeshView from_;
  Box from_box_;
  const Bvh& to_;
  Goal goal_;
  Monitor& monitor_;
  ThreadPool& pool_;
  std::function<const Adjacency*()> adjacency_source_;
  const Adjacency* adjacency_ = nullptr;
  std::atomic<double> lower_;
  double unvisited_;
  double dropped_ = 0;
  double unresolved_ = 0;
  const Options* budget_ = nullptr;
  double witness_rounding_ = 0;
  double output_rounding_ = 0;
  double start_slack_ = 0;
  Candidate candidate_;
  std::vector<Piece> waiting_;
  bool is_heap_ = true;
  Work work_;
  std::size_t survivors_ = 0;
};

}  // namespace meshgauge
