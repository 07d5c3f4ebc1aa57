#include "engine/hausdorff.h"

#include <array>
#include <functional>
#include <memory>
#include <new>

#include "engine/bisection.h"
#include "engine/bounds/n_point.h"
#include "engine/bounds/paper_bound.h"
#include "engine/certify.h"
#include "engine/conclusion.h"
#include "engine/kernels/kernels.h"
#include "engine/ordered_mesh.h"
#include "engine/prepared.h"
#include "engine/reduction.h"
#include "engine/rounding.h"
#include "engine/sampled_distances.h"
#include "engine/stage_clock.h"
#include "engine/sweep.h"
#include "engine/thread_pool.h"
#include "engine/traversal.h"
#include "engine/twins.h"

namespace meshgauge {
namespace {

constexpr std::size_t kWorthThreads = std::size_t{1} << 14;  // triangles; the start of a thread takes as long as 500

Stop to_stop(Interruption interruption) {
  return interruption == Interruption::timeout ? Stop::timeout : Stop::cancelled;
}

StatisticsStatus to_status(Interruption interruption) {
  return interruption == Interruption::timeout ? StatisticsStatus::timeout : StatisticsStatus::cancelled;
}

class Measurement final : public Monitor {
 public:
  Measurement(const Prepared& a, const Prepared& b, const Options& options, Control& control)
      : options_(options),
        control_(control),
        kernels_(find_kernels(options.simd)),
        pool_(options.strategy == Strategy::automatic ? std::max(options.threads, 1U) : 1),
        a_{a},
        b_{b} {
    const StageClock clock(outcome_.timings.build);
    on_both_sides([](Side& side, ThreadPool&) { (void)side.mesh.box(); });
    frame_ = Frame(joint(a.box(), b.box()));
    for (Side* side : {&a_, &b_}) side->framed = side->mesh.in(frame_, *kernels_);
    outcome_.simd = kernels_->name;
    outcome_.threads = static_cast<unsigned>(pool_.size());
    outcome_.diagonal_a = diagonal(a.box());
    if (a.error() > 0 || b.error() > 0) error_ = rounding::add_up(a.error(), b.error());
    const Tolerance& t = options.tolerance;
    const double width = std::max(t.absolute.value_or(0), t.diagonal.value_or(0) * outcome_.diagonal_a);
    goal_.width = frame_.length_to_frame(width);
    goal_.relative = t.relative.value_or(0);
    // Lower by what the error takes, and by the rounding of that: the search only has to get there; conclude() decides.
    if (options.max_distance) goal_.gate = frame_.length_to_frame(*options.max_distance - 2 * error_);
    if (options.direction != Direction::b_to_a) open(outcome_.a_to_b, a_, b_);
    if (options.direction != Direction::a_to_b) open(outcome_.b_to_a, b_, a_);
  }

  Outcome run() {
    auto stop = build();
    for (Course& course : courses_) {
      if (!stop && !course.settled) stop = measure(course);
    }
    conclude(stop);
    if (options_.statistics) take_statistics();
    return std::move(outcome_);
  }

  std::optional<Stop> pulse(const Search& search) override {
    if (const auto why = control_.check(); why != Interruption::none) return to_stop(why);
    if (fails_gate(search)) return Stop::gate_decided;
    if (control_.report_due()) report(search);
    return std::nullopt;
  }

  bool interrupted() override { return control_.check() != Interruption::none; }

 private:
  // One of the two meshes.
  struct Side {
    const Prepared& mesh;
    std::shared_ptr<Framed> framed = nullptr;  // what follows is its
    const OrderedMesh* ordered = nullptr;
    const Bvh* tree = nullptr;

    MeshView given() const { return mesh.mesh(); }
  };

  // One direction.
  struct Course {
    Directed& result;
    Side& from;
    Side& to;
    bool settled = false;                         // nothing is left to measure
    std::unique_ptr<OrderedMesh> rest = nullptr;  // what of `from` is not in `to` as it is, where that is worth it
  };

  // Calls work(side, pool) for both sides, at once where they are large enough, each with its share of the threads.
  template <class Work>
  void on_both_sides(const Work& work) {
    const std::array sides{&a_, &b_};
    if (pool_.size() == 1 || a_.given().triangles.size() + b_.given().triangles.size() < kWorthThreads) {
      for (Side* side : sides) work(*side, pool_);
    } else {
      pool_.run(sides.size(), [&](std::size_t, std::size_t i) {
        ThreadPool half(std::max<std::size_t>(pool_.size() / 2, 1));
        work(*sides[i], half);
      });
    }
  }

  static Box joint(Box box, const Box& other) {
    box.extend(other);
    return box;
  }

  // The interval before any work: every point of `from` is within the far corner's distance of any point of `to`.
  void open(std::optional<Directed>& directed, Side& from, Side& to) {
    directed.emplace();
    courses_.push_back({*directed, from, to});
    directed->culling.triangles = from.given().triangles.size();
    directed->culling.survivors = directed->culling.triangles;
    const Box box{frame_.to_frame(from.mesh.box().low), frame_.to_frame(from.mesh.box().high)};
    const double upper = farthest_of_box(box, frame_.to_frame(to.given().corner(0, 0)));
    directed->bounds.upper = rounding::scale_up(rounding::add_up(upper, rounding::kDistanceSlack), frame_.exponent());
    directed->bounds = widened(directed->bounds);
    floor_ = rounding::kDistanceSlack + cost_of_error();
  }

  // The interval of the meshes that are meant, from that of the meshes at hand.
  Bounds widened(Bounds bounds) const {
    if (error_ == 0) return bounds;  // not one bit changes
    bounds.lower = rounding::subtract_down(bounds.lower, error_);
    bounds.upper = rounding::add_up(bounds.upper, error_);
    return bounds;
  }

  // By how much widened() widens, in the frame, its own roundings included: those of two sums of at most 4.
  double cost_of_error() const { return error_ == 0 ? 0 : 2 * frame_.length_to_frame(error_) + 16 * rounding::kUnit; }

  Bounds certified(const Search& search) { return widened(certifier_.certify(search, frame_)); }

  bool is_auto() const { return options_.strategy == Strategy::automatic; }
  // The paper's traversal needs two trees; `auto` goes over the mesh measured from by itself.
  bool needs_tree(const Side& side) const {
    return !is_auto() || std::any_of(courses_.begin(), courses_.end(),
                                     [&](const Course& course) { return &course.to == &side && !course.settled; });
  }
  bool needs_order(const Side& side) const {
    return needs_tree(side) || std::any_of(courses_.begin(), courses_.end(), [&](const Course& course) {
             return &course.from == &side && !course.settled && !course.rest;
           });
  }

  std::optional<Stop> build() {
    const StageClock clock(outcome_.timings.build);
    stage_ = "build";
    if (is_auto()) {
      for (Course& course : courses_) {
        leave_out_shared(course);
        if (const auto why = control_.check(); why != Interruption::none) return to_stop(why);
      }
    }
    const auto order = [this](Side& side, ThreadPool& pool) { side.ordered = side.framed->order(control_, pool); };
    if (needs_order(a_) && needs_order(b_)) {
      on_both_sides(order);
    } else if (needs_order(a_) || needs_order(b_)) {
      order(needs_order(a_) ? a_ : b_, pool_);
    }
    if (const auto why = control_.check(); why != Interruption::none) return to_stop(why);
    for (Side* side : {&a_, &b_}) {
      if (!needs_tree(*side)) continue;
      side->tree = side->framed->tree(control_, pool_);
      if (!side->tree) return to_stop(control_.check());
    }
    return std::nullopt;
  }

  // A triangle that `to` has, too, is at distance 0 and needs no measuring.
  void leave_out_shared(Course& course) {
    const auto twins = shared_triangles(course.from.given(), course.to.mesh, [this] { return interrupted(); });
    if (twins.empty()) return;
    std::vector<std::uint32_t> rest;
    rest.reserve(static_cast<std::size_t>(std::count(twins.begin(), twins.end(), kNoTwin)));
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
      if (twins[t] == kNoTwin) rest.push_back(t);
    }
    if (!rest.empty()) {
      const Side& from = course.from;
      course.rest = std::make_unique<OrderedMesh>(from.given(), rest, from.mesh.box(), frame_, control_, pool_);
      return;
    }
    const Vec3& point = course.from.given().corner(0, 0);
    course.result.bounds = widened({0, 0, Witness{point, 0, point, twins[0]}});
    course.result.culling.survivors = 0;
    course.settled = true;
  }

  std::optional<Stop> measure(Course& course) {
    Directed& directed = course.result;
    const OrderedMesh& from = course.rest ? *course.rest : *course.from.ordered;
    const OrderedMesh& to = *course.to.ordered;
    Search search(from.view(), from.box, *course.to.tree, goal_, lower_, *this, pool_);
    search.set_budget(options_);
    search.set_start_slack(lower_slack_);
    search.set_witness_rounding(frame_.rounding_of_points());
    search.set_output_rounding(frame_.length_to_frame(2 * std::numeric_limits<double>::denorm_min()) + cost_of_error());
    running_ = &directed;
    certifier_ = Certifier();
    search.set_adjacency_source(
        [this, &course] { return course.to.framed->adjacency(pool_, [this] { return interrupted(); }); });
    const auto stop = is_auto() ? run_auto(search, from, to) : run_paper(search, *course.from.tree);
    const StageClock clock(outcome_.timings.certify);
    stage_ = "certify";
    const double opened = directed.bounds.upper;
    directed.bounds = certified(search);
    directed.bounds.upper = std::min(directed.bounds.upper, opened);
    directed.bounds.witness->triangle_a = from.original[directed.bounds.witness->triangle_a];
    directed.bounds.witness->triangle_b = to.original[directed.bounds.witness->triangle_b];
    directed.culling.survivors = search.survivors();
    directed.work = search.work();
    lower_ = std::max(lower_, search.lower());
    lower_slack_ = search.lower_slack();
    floor_ = std::max(floor_, search.slack() + search.unresolved_gap());
    return stop;
  }

  std::optional<Stop> run_auto(Search& search, const OrderedMesh& from, const OrderedMesh& to) {
    auto stop = staged("traverse", outcome_.timings.traverse, [&] { return sweep(search, from, to); });
    if (!stop) stop = staged("reduce", outcome_.timings.reduce, [&] { return bisect(search); });
    return stop;
  }

  // `tree`: of the mesh measured from.
  std::optional<Stop> run_paper(Search& search, const Bvh& tree) {
    const auto bound = make_paper_bound(options_, search);
    auto stop = staged("traverse", outcome_.timings.traverse, [&] { return traverse(search, tree, *bound); });
    if (!stop) stop = staged("reduce", outcome_.timings.reduce, [&] { return reduce(search, *bound); });
    return stop;
  }

  template <class Work>
  std::optional<Stop> staged(const char* name, double& total_ms, Work&& work) {
    const StageClock clock(total_ms);
    stage_ = name;
    return work();
  }

  // Certifying costs one query, so it is asked for only when the lower bound has moved.
  bool fails_gate(const Search& search) {
    if (!search.above_gate()) return false;
    if (search.lower() != gate_checked_at_) {
      gate_checked_at_ = search.lower();
      gate_failed_ = certified(search).lower > *options_.max_distance;
    }
    return gate_failed_;
  }

  void report(const Search& search) {
    const Bounds before = running_->bounds;
    running_->bounds = certified(search);
    running_->bounds.upper = std::min(running_->bounds.upper, before.upper);
    take_maximum(outcome_);
    control_.report({outcome_.lower, outcome_.upper, stage_});
    running_->bounds = before;
  }

  void conclude(std::optional<Stop> stop) {
    take_maximum(outcome_);
    outcome_.precision_floor = rounding::scale_up(floor_, frame_.exponent());
    outcome_.met_by = rule_met(options_.tolerance, outcome_.lower, outcome_.upper, outcome_.diagonal_a);
    if (outcome_.met_by) {
      outcome_.stop = Stop::converged;
    } else if (gate_decided(options_.max_distance, outcome_.lower, outcome_.upper)) {
      outcome_.stop = Stop::gate_decided;
    } else {
      outcome_.stop = stop.value_or(Stop::precision_floor);
    }
  }

  // From here on the interval does not change, and nothing that fails here may lose it.
  void take_statistics() {
    const StageClock clock(outcome_.timings.statistics);
    stage_ = "statistics";
    Statistics& statistics = outcome_.statistics.emplace();
    statistics.sampling = *options_.statistics;
    try {
      for (const Course& course : courses_) {
        auto& found = &course.from == &a_ ? statistics.a_to_b : statistics.b_to_a;
        found = sampled(course);
        if (!found) statistics.status = to_status(control_.check());
      }
    } catch (const std::bad_alloc&) {
      statistics.status = StatisticsStatus::memory;
    }
  }

  std::optional<Distribution> sampled(const Course& course) {
    const std::function<void()> tell = [this] {
      if (control_.report_due()) control_.report({outcome_.lower, outcome_.upper, stage_});
    };
    const std::uint32_t stream = &course.from == &a_ ? 0 : 1;
    return distribution({*course.from.framed, *course.to.framed, *options_.statistics, stream, pool_, control_, tell},
                        course.result.bounds.upper);
  }

  const Options& options_;
  Control& control_;
  const Kernels* kernels_;
  ThreadPool pool_;
  Side a_;
  Side b_;
  std::vector<Course> courses_;
  Frame frame_;
  Goal goal_;
  Outcome outcome_;
  Directed* running_ = nullptr;
  const char* stage_ = "";
  double lower_ = 0;        // largest computed distance of the directions done; frame units
  double lower_slack_ = 0;  // what certifying takes from it
  double floor_ = 0;        // frame units
  double error_ = 0;        // of both meshes together (Prepared::error); in their unit
  Certifier certifier_;
  double gate_checked_at_ = -1;  // computed lower bound when the gate was last tried
  bool gate_failed_ = false;
};

}  // namespace

Work& Work::operator+=(const Work& other) {
  nearest_queries += other.nearest_queries;
  cache_hits += other.cache_hits;
  triangle_tests += other.triangle_tests;
  subdivisions += other.subdivisions;
  max_depth = std::max(max_depth, other.max_depth);
  peak_heap = std::max(peak_heap, other.peak_heap);
  return *this;
}

bool is_stencil(int points) { return stencil_level(points).has_value(); }

std::span<const std::string_view> supported_simd() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> result;
    for (const Kernels& kernels : supported_kernels()) result.emplace_back(kernels.name);
    return result;
  }();
  return names;
}

const char* version() { return MESHGAUGE_VERSION; }

Outcome measure(const Prepared& a, const Prepared& b, const Options& options, Control& control) {
  return Measurement(a, b, options, control).run();
}

Outcome measure(MeshView a, MeshView b, const Options& options, Control& control) {
  return measure(Prepared(a), Prepared(b), options, control);
}

}  // namespace meshgauge
