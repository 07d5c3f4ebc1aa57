#include "engine/search.h"

#include "engine/rounding.h"

namespace meshgauge {
namespace {

bool less_upper(const Piece& a, const Piece& b) { return a.upper < b.upper; }

}  // namespace

double Goal::gap(double lower, double slack) const {
  return std::max(rounding::kSmallestGap, std::max(width, relative * std::max(0.0, lower - slack)) - slack);
}

Search::Search(const Bvh& from, const Bvh& to, const Goal& goal, double start_lower, Monitor& monitor)
    : from_(from),
      to_(to),
      goal_(goal),
      monitor_(monitor),
      lower_(start_lower),
      unvisited_(farthest_of_box(from.nodes()[Bvh::kRoot].box, to.mesh().corner(0, 0))) {
  culling_.triangles = from.mesh().triangles.size();
  saw(nearest_corner(to, from.mesh().corner(0, 0), work_), 0, true);
}

double Search::upper() const {
  return std::max({lower_, dropped_, unvisited_, heap_.empty() ? 0.0 : heap_.front().upper});
}

double Search::lower_slack() const {
  const bool interior = !candidate_.is_vertex;
  return rounding::kSeparationSlack + rounding::kDistanceSlack + to_.residual() +
         (interior ? rounding::kDistanceSlack + from_.residual() + 2 * witness_rounding_ : 0.0);
}

double Search::upper_slack() const { return rounding::upper_slack(to_.residual(), work_.max_depth); }

void Search::saw(const Corner& corner, std::uint32_t triangle, bool is_vertex) {
  if (corner.distance <= candidate_.distance) return;
  candidate_ = Candidate{corner.point, corner.distance, triangle, is_vertex};
  lower_ = std::max(lower_, corner.distance);
}

double Search::cull_below() const {
  if (!goal_.gate) return lower_;
  // With the slack of a depth that is never reached, so that what was dropped stays below the gate later on.
  return std::max(lower_, *goal_.gate - rounding::upper_slack(to_.residual(), rounding::kDepthAllowance));
}

void Search::push(const Piece& piece) {
  heap_.push_back(piece);
  std::push_heap(heap_.begin(), heap_.end(), less_upper);
  work_.peak_heap = std::max(work_.peak_heap, heap_.size());
}

Piece Search::pop() {
  std::pop_heap(heap_.begin(), heap_.end(), less_upper);
  const Piece piece = heap_.back();
  heap_.pop_back();
  return piece;
}

bool Search::reached_goal() const {
  const double now = upper();
  return now <= cull_below() || now - lower_ <= goal_.gap(lower_, slack());
}

}  // namespace meshgauge
