#include "engine/fast/bisection.h"

#include <algorithm>
#include <deque>

#include "engine/fast/bounds/lipschitz.h"
#include "engine/fast/bounds/overlay.h"
#include "engine/fast/bounds/owner_cut.h"
#include "engine/rounding.h"
#include "engine/search/search_worker.h"

namespace meshgauge {
namespace {

constexpr std::size_t kSettled = 256;       // pieces without a new lower bound, after which the search goes depth first
constexpr std::size_t kMaxVisits = 64;      // limit of the triangles of B over one piece
constexpr std::size_t kTogether = 16;       // pieces for each thread that are treated at once until then
constexpr std::size_t kWorthThreads = 256;  // waiting pieces from which on they are
constexpr std::size_t kWorthAdjacency = 8;  // pieces waiting or split below which no adjacency is made for the overlay
constexpr std::size_t kAdjacencyShare = 256;  // triangles of B whose adjacency costs as much as one such piece
constexpr int kCutParts = 64;                 // of a piece in a thorough owner cut
constexpr int kCutQueries = 4;                // in a thorough owner cut
constexpr std::uint64_t kCostOfSingle = 4;    // a distance computed by itself costs as much as so many of eight at once
constexpr std::size_t kTasksARound = 16;      // for each thread, between two pulses
constexpr std::size_t kPiecesATask = 16;      // waiting pieces in a task
constexpr std::size_t kStepsATask =
    256;  // limit of the pieces that a task treats, some 0.3 ms; the rest waits for the next round

// Limits what failed attempts at a bound cost, in point-triangle distances, to a share of those of all other work.
class Credit {
 public:
  // `others`: the distances of the work so far; `gain`: what a success gives of what it cost.
  Credit(std::uint64_t others, std::int64_t gain) : gain_(gain) { earn(others); }
  bool left() const { return credit_ > 0; }
  void earn(std::uint64_t others) { credit_ = std::min(credit_ + static_cast<std::int64_t>(others) / kShare, kMost); }
  void note(bool success, std::uint64_t cost) {
    const auto signed_cost = static_cast<std::int64_t>(cost);
    credit_ = std::min(credit_ + (success ? gain_ * signed_cost : -signed_cost), kMost);
  }

 private:
  static constexpr std::int64_t kShare = 16, kLeast = 1 << 9, kMost = 1 << 12;
  std::int64_t credit_ = kLeast;
  std::int64_t gain_;
};

struct Longest {
  std::size_t edge = 0;  // joins the corners `edge` and edge + 1 (mod 3)
  double length = 0;
};

Longest longest_edge(const Piece& piece) {
  Longest best;
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = norm(piece.corners[i].point - piece.corners[(i + 1) % 3].point);
    if (length > best.length) best = {i, length};
  }
  return best;
}

// One thread's state in the bisection. No two share a cache line, which both would write.
class alignas(64) Bisector {
 public:
  explicit Bisector(Search& search)
      : worker_(search),
        simple_cuts_(search.work().triangle_tests, 4),
        thorough_cuts_(search.work().triangle_tests, 0) {}

  SearchWorker& worker() { return worker_; }
  bool has_overlay() const { return overlay_.has_value(); }
  void adopt_overlay(const Adjacency& adjacency) { overlay_.emplace(worker_.to(), adjacency); }

  void treat(const Piece& piece) {
    if (piece.upper <= worker_.cull_within_tolerance()) return worker_.drop(piece.upper);
    Overlay::Attempt overlay;
    if (overlay_ && !piece.overlay_failed) overlay = attempt(piece);
    if (overlay.upper) {
      return *overlay.upper > worker_.cull_within_tolerance() ? worker_.cull_unresolved(*overlay.upper)
                                                              : worker_.drop(*overlay.upper);
    }
    if (cut(piece)) return;
    const Longest longest = longest_edge(piece);
    if (longest.length < rounding::kSmallestPiece) return worker_.drop(std::min(piece.upper, lipschitz_upper(piece)));
    split(piece, longest.edge, overlay.too_far);
  }

 private:
  Overlay::Attempt attempt(const Piece& piece) {
    const double limit = std::max(worker_.cull_within_tolerance(), worker_.lower() + rounding::kOverlayGap);
    const auto& [a, b, c] = piece.corners;
    return overlay_->attempt(piece, std::array{a.slot, b.slot, c.slot}, limit, kMaxVisits, worker_.work());
  }

  // Tries to drop the piece by the owner cut: thoroughly, with parts and queries, or else as a whole. Returns whether
  // it did.
  bool cut(const Piece& piece) {
    const bool thorough = thorough_cuts_.left();
    Credit& credit = thorough ? thorough_cuts_ : simple_cuts_;
    if (!credit.left()) return false;
    const std::uint64_t before = worker_.work().triangle_tests;
    Work single;  // distances computed one by one
    const std::optional<double> upper =
        thorough ? cut_upper(piece, kCutParts, kCutQueries, single) : cut_upper(piece, 1, 0, single);
    credit.note(upper.has_value(), worker_.work().triangle_tests - before + kCostOfSingle * single.triangle_tests);
    worker_.work() += single;
    if (upper) *upper > worker_.cull_within_tolerance() ? worker_.cull_unresolved(*upper) : worker_.drop(*upper);
    return upper.has_value();
  }

  // Where an attempt fails at a point that is too far from the triangles known, a query of that point either raises the
  // lower bound or finds another triangle.
  std::optional<double> cut_upper(const Piece& piece, int parts, int queries, Work& single) {
    OwnerCut cut(piece, worker_.to(), single);
    for (;; --queries) {
      const double limit = std::max(worker_.cull_within_tolerance(), worker_.lower() + rounding::kCutGap);
      const OwnerCut::Attempt attempt = cut.attempt(limit, parts);
      if (attempt.upper || !attempt.too_far || queries == 0) return attempt.upper;
      const Corner peak =
          nearest_corner(worker_.to(), *attempt.too_far, worker_.work(), worker_.stop(), piece.corners[0].slot);
      worker_.observe(peak, piece.triangle, false);
      if (peak.distance <= limit && !cut.add(peak.slot)) return std::nullopt;
    }
  }

  // `too_far`: the point where the overlay bound of the whole piece failed. The half that holds it would fail again.
  void split(const Piece& piece, std::size_t edge, const std::optional<Vec3>& too_far) {
    Work& work = worker_.work();
    ++work.subdivisions;
    work.max_depth = std::max(work.max_depth, piece.depth + 1);
    const Corner &a = piece.corners[edge], &b = piece.corners[(edge + 1) % 3], &c = piece.corners[(edge + 2) % 3];
    const std::uint64_t before = work.triangle_tests;
    const Corner middle = nearest_corner(worker_.to(), (a.point + b.point) * 0.5, work, worker_.stop(), a.slot);
    simple_cuts_.earn(work.triangle_tests - before);
    thorough_cuts_.earn(work.triangle_tests - before);
    worker_.observe(middle, piece.triangle, false);
    const bool at_a = too_far && beside(*too_far, a.point, middle.point, c.point);
    add({a, middle, c}, piece, at_a);
    add({middle, b, c}, piece, too_far && !at_a);
  }

  // Whether p lies on a's side of the line from `middle` to c, in the plane of the three.
  static bool beside(const Vec3& p, const Vec3& a, const Vec3& middle, const Vec3& c) {
    const Vec3 line = c - middle, to_a = a - middle;
    const Vec3 across = to_a * squared_norm(line) - line * dot(line, to_a);
    return dot(p - middle, across) > 0;
  }

  void add(const std::array<Corner, 3>& corners, const Piece& parent, bool overlay_failed) {
    Piece part{corners, parent.upper, parent.triangle, parent.depth + 1, overlay_failed};
    part.upper = std::min(part.upper, lipschitz_upper(part));
    if (part.upper > worker_.cull_within_tolerance()) {
      const std::array owners{corners[0].slot, corners[1].slot, corners[2].slot};
      part.upper = std::min(part.upper, least_farthest(part, worker_.to(), owners, worker_.work()));
    }
    if (part.upper <= worker_.cull_within_tolerance()) return worker_.drop(part.upper);
    worker_.push(part);
  }

  SearchWorker worker_;
  std::optional<Overlay> overlay_;
  Credit simple_cuts_;
  Credit thorough_cuts_;
};

class Bisection {
 public:
  explicit Bisection(Search& search) : search_(search) {
    for (std::size_t i = 0; i < search.pool().size(); ++i) bisectors_.emplace_back(search);
  }

  std::optional<Stop> run() {
    if (const auto stop = best_first()) return stop;
    search_.depth_first();
    return depth_first();
  }

 private:
  // Treats the pieces with the largest bounds until the lower bound has settled.
  std::optional<Stop> best_first() {
    std::size_t since_rise = 0;
    double last_lower = search_.lower();
    while (!search_.empty() && since_rise <= kSettled) {
      if (const auto stop = reason_to_stop()) return stop;
      if (overlay_pays()) adopt_overlay();
      const std::size_t treated = run_round(together(), 1, 1);
      since_rise = search_.lower() > last_lower ? 0 : since_rise + treated;
      last_lower = search_.lower();
    }
    return std::nullopt;
  }

  std::optional<Stop> depth_first() {
    while (!search_.empty()) {
      if (const auto stop = reason_to_stop()) return stop;
      if (overlay_pays()) adopt_overlay();
      run_round(search_.pool().size() * kTasksARound * kPiecesATask, kPiecesATask, kStepsATask);
    }
    return std::nullopt;
  }

  // How many pieces are treated before the bounds are looked at again: one, unless several threads have enough to do.
  std::size_t together() const {
    const std::size_t threads = search_.pool().size();
    return threads == 1 || search_.waiting() < kWorthThreads ? 1 : threads * kTogether;
  }

  // Hands up to `most` of the waiting pieces to the threads, `a_task` in a task of at most so many `steps`, and takes
  // back what is left of them. Returns how many it has handed out.
  std::size_t run_round(std::size_t most, std::size_t a_task, std::size_t steps) {
    const std::uint64_t left = search_.work_items_left();  // limits the steps of this round
    const std::size_t count =
        static_cast<std::size_t>(std::min<std::uint64_t>({search_.waiting(), most, std::max<std::uint64_t>(left, 1)}));
    taken_.clear();
    for (std::size_t i = 0; i < count; ++i) taken_.push_back(search_.pop());
    const std::size_t tasks = std::max<std::size_t>((count + a_task - 1) / a_task, 1);
    const auto steps_left = static_cast<std::size_t>(std::clamp<std::uint64_t>(left / tasks, 1, steps));
    search_.pool().run(tasks, [&](std::size_t w, std::size_t task) {
      const std::size_t begin = task * a_task;
      work_at(bisectors_[w], std::span(taken_).subspan(begin, std::min(a_task, count - begin)), steps_left);
    });
    for (Bisector& bisector : bisectors_) search_.absorb(bisector.worker());
    return count;
  }

  // Treats the pieces depth first, `steps` steps at most. What is left stays in the worker for absorb().
  static void work_at(Bisector& bisector, std::span<const Piece> pieces, std::size_t steps) {
    SearchWorker& worker = bisector.worker();
    const std::size_t others = worker.waiting();  // left by earlier tasks
    for (const Piece& piece : pieces) {
      worker.push(piece);
      while (worker.waiting() > others && steps > 0 && !worker.interrupted()) {
        --steps;
        bisector.treat(worker.pop());
      }
    }
  }

  std::optional<Stop> reason_to_stop() const {
    if (const auto stop = search_.pulse()) return stop;
    return search_.over_budget() ? std::optional(Stop::budget) : std::nullopt;
  }

  bool overlay_pays() const {
    if (bisectors_[0].has_overlay()) return false;
    const std::uint64_t pieces = search_.waiting() + search_.work().subdivisions;
    return search_.adjacency() ||
           pieces >= std::max(kWorthAdjacency, search_.to().mesh().triangles.size() / kAdjacencyShare);
  }
  void adopt_overlay() {
    if (!search_.take_adjacency()) return;
    for (Bisector& bisector : bisectors_) bisector.adopt_overlay(*search_.adjacency());
  }

  Search& search_;
  std::deque<Bisector> bisectors_;  // one for each thread
  std::vector<Piece> taken_;        // by the threads, in this round
};

}  // namespace

std::optional<Stop> bisect(Search& search) { return Bisection(search).run(); }

}  // namespace meshgauge
