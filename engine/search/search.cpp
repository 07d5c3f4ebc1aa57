#include "engine/search/search.h"

#include "engine/search/heap.h"
#include "engine/search/search_worker.h"

namespace meshgauge {
namespace {

constexpr auto less_upper = [](const Piece& a, const Piece& b) { return a.upper < b.upper; };

}  // namespace

Goal goal_of(const Options& options, double diagonal_a, const Frame& frame) {
  const Tolerance& rules = options.tolerance;
  const double width = std::max(rules.absolute.value_or(0), rules.diagonal.value_or(0) * diagonal_a);
  Goal goal;
  goal.width = frame.length_to_frame(width);
  goal.relative = rules.relative.value_or(0);
  return goal;
}

double Goal::gap(double lower, double slack) const {
  return std::max(rounding::kSmallestGap, std::max(width, relative * std::max(0.0, lower - slack)) - slack);
}

double Slack::lower(bool interior) const {
  const double point = rounding::kSeparationSlack + rounding::kDistanceSlack + residual;
  const double off = rounding::kDistanceSlack + 2 * rounding::kResidualSlack + 2 * witness_rounding;
  return std::max(start, interior ? point + off : point);
}

double Goal::cull_below(double lower, const Slack& slack) const {
  return gate ? std::max(lower, *gate - slack.upper(rounding::kDepthAllowance)) : lower;
}

double Goal::cull_within_tolerance(double lower, const Slack& slack) const {
  if (cull_at) return *cull_at;
  return std::max(cull_below(lower, slack), lower + gap(lower, slack.to_come()));
}

Search::Search(MeshView from, const Box& from_box, const Bvh& to, const Goal& goal, double start_lower,
               Monitor& monitor, ThreadPool& pool)
    : from_(from),
      from_box_(from_box),
      to_(to),
      goal_(goal),
      monitor_(monitor),
      pool_(pool),
      lower_(start_lower),
      unvisited_(farthest_of_box(from_box, to.mesh().corner(0, 0))) {
  slack_.residual = to.residual();
  candidate_.point = from.corner(0, 0);  // also when the query is stopped
  observe(nearest_corner(to, candidate_.point, work_, stop()), 0, true);
}

double Search::upper() const {
  double waiting = 0;
  if (is_stack_) {
    for (const Piece& piece : waiting_) waiting = std::max(waiting, piece.upper);
  } else {
    waiting = heap_ > 0 ? std::max(waiting_.front().upper, pushed_) : pushed_;
  }
  return std::max({lower(), dropped_, unvisited_, waiting});
}

void Search::set_slack(const Slack& slack) {
  slack_ = slack;
  slack_.residual = to_.residual();
}

double Search::lower_slack() const { return slack_.lower(!candidate_.is_vertex); }

double Search::upper_slack() const { return slack_.upper(work_.max_depth); }

void Search::observe(const Corner& corner, std::uint32_t triangle, bool is_vertex) {
  if (!corner.complete || corner.distance <= candidate_.distance) return;
  candidate_ = Candidate{corner.point, corner.distance, triangle, is_vertex};
  raise_lower(corner.distance);
}

void Search::measure_corners(std::uint32_t triangle) {
  for (int i = 0; i < 3; ++i) observe(nearest_corner(to_, from_.corner(triangle, i), work_, stop()), triangle, true);
}

void Search::push(const Piece& piece) {
  waiting_.push_back(piece);
  pushed_ = std::max(pushed_, piece.upper);
  work_.peak_heap = std::max(work_.peak_heap, waiting_.size());
}

Piece Search::pop() {
  if (!is_stack_) {
    for (; heap_ < waiting_.size(); ++heap_) {
      push_heap(std::span(waiting_).first(heap_ + 1), less_upper);
    }
    pop_heap(std::span(waiting_), less_upper);
    --heap_;
    pushed_ = 0;
  }
  const Piece piece = waiting_.back();
  waiting_.pop_back();
  return piece;
}

void Search::keep_above(double limit) {
  std::erase_if(waiting_, [&](const Piece& piece) {
    if (piece.upper > limit) return false;
    drop(piece.upper);
    return true;
  });
  make_heap(std::span(waiting_), less_upper);
  heap_ = waiting_.size();
  pushed_ = 0;
}

bool Search::take_adjacency() {
  if (!adjacency_) adjacency_ = adjacency_source_();
  return adjacency_ != nullptr;
}

void Search::absorb(SearchWorker& worker) {
  if (worker.candidate_.distance > candidate_.distance) candidate_ = worker.candidate_;
  drop(worker.dropped_);
  unresolved_ = std::max(unresolved_, worker.unresolved_);
  work_ += worker.work_;
  for (const Piece& piece : worker.pieces_) push(piece);
  worker.dropped_ = worker.unresolved_ = 0;
  worker.work_ = Work{};
  worker.next_poll_ = kTestsBetweenPolls;
  worker.pieces_.clear();
}

bool Search::over_budget(std::size_t others_bytes) const {
  if (!budget_) return false;
  const std::size_t bytes = waiting_.capacity() * sizeof(Piece) + others_bytes;
  return bytes > budget_->max_memory_bytes || work_.subdivisions >= budget_->max_work_items;
}

bool Search::reached_goal() const {
  const double now = upper();
  return now <= cull_below() || now - lower() <= goal_.gap(lower(), slack());
}

}  // namespace meshgauge
