// What one thread finds while it searches a part of A. Search::absorb() takes it over.
//
// The lower bound alone is shared at once; everything else stays in the worker until then.
#pragma once

#include <vector>

#include "engine/search/search.h"

namespace meshgauge {

// One for each thread; not thread safe.
class SearchWorker {
 public:
  explicit SearchWorker(Search& search) : search_(search) {}

  const Bvh& to() const { return search_.to(); }
  const Interrupted* stop() const { return search_.stop(); }
  Work& work() { return work_; }

  // As the functions of Search of the same names.
  double lower() const { return search_.lower(); }
  double cull_within_tolerance() {
    const double lower_now = lower();
    if (lower_now != known_limit_.lower) known_limit_ = {lower_now, search_.cull_within_tolerance(lower_now)};
    return known_limit_.limit;
  }
  void observe(const Corner& corner, std::uint32_t triangle, bool is_vertex) {
    if (!corner.complete || corner.distance <= candidate_.distance || corner.distance <= search_.lower()) return;
    candidate_ = Candidate{corner.point, corner.distance, triangle, is_vertex};
    search_.raise_lower(corner.distance);
  }
  void drop(double upper) { dropped_ = std::max(dropped_, upper); }
  // Drops a triangle of A, and notes the bound: Search::note().
  void drop(std::size_t triangle, double upper) {
    drop(upper);
    search_.note(triangle, upper);
  }
  // Drops a piece whose bound is above the tolerance but which rounding does not let resolve any further.
  void cull_unresolved(double upper) {
    unresolved_ = std::max(unresolved_, upper);
    drop(upper);
  }

  // The pieces that absorb() will take: a stack.
  void push(const Piece& piece) { pieces_.push_back(piece); }
  Piece pop() {
    const Piece piece = pieces_.back();
    pieces_.pop_back();
    return piece;
  }
  std::size_t waiting() const { return pieces_.size(); }
  // Keeps the first `count` pieces. For a block that is interrupted: the whole block counts as not visited.
  void forget_beyond(std::size_t count) { pieces_.resize(count); }

  // Whether the search must end. Polls the monitor about every 0.1 ms of work.
  bool interrupted() {
    if (interrupted_ || work_.triangle_tests < next_poll_) return interrupted_;
    next_poll_ = work_.triangle_tests + kTestsBetweenPolls;
    interrupted_ = search_.interrupted();
    return interrupted_;
  }

 private:
  friend void Search::absorb(SearchWorker&);

  Search& search_;
  Candidate candidate_;
  double dropped_ = 0;
  double unresolved_ = 0;
  std::vector<Piece> pieces_;
  Work work_;
  std::uint64_t next_poll_ = kTestsBetweenPolls;  // next poll of the monitor, in triangle tests
  bool interrupted_ = false;

  struct Limit {
    double lower;
    double limit;  // cull_within_tolerance() for it
  };
  Limit known_limit_{-1, 0};
};

}  // namespace meshgauge
