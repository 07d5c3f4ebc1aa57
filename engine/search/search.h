// The state of one direction of a measurement while it runs: from mesh A to mesh B, in the unit frame.
//
// Invariant between two calls, once absorb() has taken what the SearchWorkers found:
//   lower() - slack() <= max(start_lower, h(A,B))   and   h(A,B) <= upper() + slack()
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/mesh/adjacency.h"
#include "engine/mesh/frame.h"
#include "engine/options.h"
#include "engine/outcome.h"
#include "engine/rounding.h"
#include "engine/search/piece.h"
#include "engine/thread_pool.h"
#include "engine/thresholds.h"

namespace meshgauge {

// The sample of A with the largest distance so far, in frame coordinates.
struct Candidate {
  Vec3 point = Vec3::Zero();
  double distance = -1;  // computed; -1: no sample yet
  std::uint32_t triangle = 0;
  bool is_vertex = true;  // a vertex of A, hence exactly on A
};

// The largest distance of a point of the box from b: bounds h(box, B) for any point b of B (eq. 4/5).
inline double farthest_of_box(const Box& box, const Vec3& b) {
  return norm((b - box.low).cwiseAbs().cwiseMax((box.high - b).cwiseAbs()));
}

// By how much certifying widens the computed bounds of a search. Frame units.
struct Slack {
  double residual = 0;          // of B's prepared triangles: rounding.h R2
  double witness_rounding = 0;  // how far the reported witness may lie from the candidate: the file's coordinates are
                                // coarser
  double output_rounding = 0;   // the rounding of the scaling back to the meshes' unit (0 unless the results are
                                // subnormal) and the input error
  double start = 0;             // what certifying takes from the lower bound that the search starts with

  // What certifying takes from the lower bound. `interior`: the candidate is not a vertex of A.
  double lower(bool interior) const;
  // What it adds to the upper bound, with pieces of this depth.
  double upper(std::uint32_t depth) const { return rounding::upper_slack(residual, depth); }
  // The sum of both, with an interior candidate and at a depth that is never reached: a piece that is dropped now must
  // be within the tolerance at the end.
  double to_come() const { return output_rounding + lower(true) + upper(rounding::kDepthAllowance); }
};

// When a search may end. Lengths in frame units.
struct Goal {
  double width = 0;               // the absolute and the diagonal rule: upper - lower <= width
  double relative = 0;            // the relative rule: upper - lower <= relative * lower
  std::optional<double> gate;     // Options::max_distance, less the input error
  std::optional<double> cull_at;  // cull_within_tolerance() instead, whatever the lower bound is (area/places.h)

  // The largest computed gap upper - lower at which a rule will hold after certifying, but at least
  // rounding::kSmallestGap. `slack`: by how much certifying will widen the interval.
  double gap(double lower, double slack) const;

  // Parts of A with upper bounds of at most this can neither raise the lower bound nor fail the gate: they may be
  // dropped.
  double cull_below(double lower, const Slack& slack) const;
  // The same for strategy `auto`, which also drops what is within the tolerance of the lower bound.
  double cull_within_tolerance(double lower, const Slack& slack) const;
};

// Returns what the options ask of a search in this frame, without the gate: its limit changes while a measurement runs.
// `diagonal_a`: that of mesh A, in the meshes' unit.
Goal goal_of(const Options& options, double diagonal_a, const Frame& frame);

class Search;
class SearchWorker;

// Decides between the steps of a search whether it goes on: deadline, cancellation, gate.
class Monitor {
 public:
  Monitor() = default;
  Monitor(const Monitor&) = delete;
  Monitor& operator=(const Monitor&) = delete;
  virtual ~Monitor() = default;
  // Called between two steps, when the search's bounds hold. Returns the reason to stop now; nullopt: go on.
  virtual std::optional<Stop> pulse(const Search& search) = 0;
  // Called inside a step, on any thread. Whether the next pulse() will return a reason. Must not read the bounds.
  virtual bool interrupted() = 0;
};

// Belongs to one thread. Any thread may call lower(), raise_lower(), cull_within_tolerance() and interrupted().
class Search {
 public:
  // Measures one vertex of A, so that there is a candidate from the start. `from_box` is the box of A. `start_lower`:
  // the lower bound to begin with, which the other direction has reached already. Borrows all references.
  Search(MeshView from, const Box& from_box, const Bvh& to, const Goal& goal, double start_lower, Monitor& monitor,
         ThreadPool& pool);

  // Mesh A, its box, and the tree of mesh B.
  MeshView from() const { return from_; }
  const Box& from_box() const { return from_box_; }
  const Bvh& to() const { return to_; }
  ThreadPool& pool() const { return pool_; }
  // The monitor's answers.
  std::optional<Stop> pulse() { return monitor_.pulse(*this); }
  bool interrupted() const { return monitor_.interrupted(); }
  // interrupted(), for queries.
  const Interrupted* stop() const { return &stop_; }
  Work& work() { return work_; }
  const Work& work() const { return work_; }
  // Triangles of A that the traversal could not cull.
  std::size_t& survivors() { return survivors_; }
  std::size_t survivors() const { return survivors_; }
  const Goal& goal() const { return goal_; }

  // The computed bounds in frame units, without slack, and the sample with the largest distance.
  double lower() const { return lower_.load(std::memory_order_relaxed); }
  double upper() const;
  const Candidate& candidate() const { return candidate_; }

  // What certifying would take from the lower bound and add to the upper bound now. Frame units, like all slacks here.
  double lower_slack() const;
  double upper_slack() const;
  double slack() const { return lower_slack() + upper_slack() + slack_.output_rounding; }
  // All but the residual, which is that of the tree of B.
  void set_slack(const Slack& slack);
  // Sets a lower bound of the distance of each point of A from each triangle of the mesh B that is not in the tree;
  // infinite: the tree holds all of B.
  void set_reach(double reach) { reach_ = reach; }
  double reach() const { return reach_; }

  // Raises the lower bound to a computed distance of a sample of A. Any thread may call it, before absorb() takes the
  // sample over as the candidate.
  void raise_lower(double distance) {
    double known = lower();
    while (distance > known && !lower_.compare_exchange_weak(known, distance, std::memory_order_relaxed)) {
    }
  }
  // Takes a sample of A at the computed distance `corner.distance` from B: raises the lower bound and the candidate,
  // unless its query was stopped.
  void observe(const Corner& corner, std::uint32_t triangle, bool is_vertex);
  // Observes the three corners of this triangle of A.
  void measure_corners(std::uint32_t triangle);

  // Limits of the goal for the present lower bound.
  double cull_below() const { return goal_.cull_below(lower(), slack_); }
  double cull_within_tolerance() const { return cull_within_tolerance(lower()); }
  // The same for a given lower bound; depends on nothing else that changes.
  double cull_within_tolerance(double lower) const { return goal_.cull_within_tolerance(lower, slack_); }
  // Records that a piece with this upper bound is not followed any further: upper() stays at least as large.
  void drop(double upper) { dropped_ = std::max(dropped_, upper); }
  // The smallest gap between the computed bounds that the search can reach.
  double unresolved_gap() const { return std::max(rounding::kSmallestGap, unresolved_ - lower()); }

  // The pieces that wait for the next phase: the one with the largest bound comes first, or the last one once
  // depth_first() was called.
  void push(const Piece& piece);
  Piece pop();
  bool empty() const { return waiting_.empty(); }
  std::size_t waiting() const { return waiting_.size(); }
  void depth_first() { is_stack_ = true; }
  // Drops the pieces whose bounds are at most `limit`.
  void keep_above(double limit);

  // Sets max_memory_bytes, max_work_items and the thresholds; without it there is no budget. Borrows `options`.
  void set_options(const Options& options) {
    budget_ = &options;
    thresholds_ = options.thresholds;
  }
  const Thresholds& thresholds() const { return thresholds_; }
  // Whether the waiting pieces and `others_bytes`, the strategy's own memory, exceed the memory, or all work items are
  // used: the search should end with Stop::budget.
  bool over_budget(std::size_t others_bytes = 0) const;
  // How many pieces may still be split.
  std::uint64_t work_items_left() const {
    return budget_ ? budget_->max_work_items - std::min(budget_->max_work_items, work_.subdivisions)
                   : std::numeric_limits<std::uint64_t>::max();
  }

  // Upper bounds of the distances of the triangles of A, by triangle, slack included; infinite: none. The first phase
  // drops what is within its limit by the known ones, and notes those of what it drops itself. Borrows; empty: none.
  void set_known(std::span<const float> bounds) { known_ = bounds; }
  void note_in(std::span<float> bounds) { noted_ = bounds; }
  double known(std::size_t triangle) const {
    return known_.empty() ? std::numeric_limits<double>::infinity() : static_cast<double>(known_[triangle]);
  }
  // Any thread may call it for triangles that no other thread notes. `upper`: computed.
  void note(std::size_t triangle, double upper) {
    if (!noted_.empty())
      noted_[triangle] = std::min(noted_[triangle], rounding::float_up(rounding::add_up(upper, slack_.upper(0))));
  }

  // Sets the upper bound of the part of A that the first phase has not visited yet; 0: it has visited all.
  void set_unvisited(double upper) { unvisited_ = upper; }

  // The adjacency of B; nullptr: take_adjacency() has not succeeded yet.
  const Adjacency* adjacency() const { return adjacency_; }
  // Makes adjacency() available by calling the source, unless it is already. False: the source was interrupted and
  // returned nullptr.
  bool take_adjacency();
  void set_adjacency_source(std::function<const Adjacency*()> source) { adjacency_source_ = std::move(source); }

  // Takes over what a worker has found, and empties the worker.
  void absorb(SearchWorker& worker);

  // Whether a rule will hold, or the gate passes, without more work.
  bool reached_goal() const;
  // Whether the computed lower bound exceeds the gate by more than its slack: certifying may show that the gate fails.
  bool above_gate() const { return goal_.gate && lower() - lower_slack() > *goal_.gate; }

 private:
  MeshView from_;
  Box from_box_;
  const Bvh& to_;
  Goal goal_;
  Monitor& monitor_;
  const Interrupted stop_ = [this] { return interrupted(); };
  ThreadPool& pool_;
  std::function<const Adjacency*()> adjacency_source_;
  const Adjacency* adjacency_ = nullptr;
  std::atomic<double> lower_;
  double unvisited_;
  double dropped_ = 0;
  double unresolved_ = 0;
  const Options* budget_ = nullptr;
  Thresholds thresholds_;
  Slack slack_;
  double reach_ = std::numeric_limits<double>::infinity();
  Candidate candidate_;
  std::span<const float> known_;
  std::span<float> noted_;
  std::vector<Piece> waiting_;  // a max-heap by upper bound, and then those that no pop() has sorted in yet; or a stack
  std::size_t heap_ = 0;        // pieces in the heap
  double pushed_ = 0;           // the largest bound of those after it
  bool is_stack_ = false;
  Work work_;
  std::size_t survivors_ = 0;
};

}  // namespace meshgauge
