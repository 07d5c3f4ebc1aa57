#include "engine/measure/measurement.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "engine/extras/area/area_stage.h"
#include "engine/extras/statistics/statistics_stage.h"
#include "engine/fast/bisection.h"
#include "engine/fast/sweep.h"
#include "engine/measure/build_stage.h"
#include "engine/measure/region_stage.h"
#include "engine/paper/four_point.h"
#include "engine/paper/n_point.h"
#include "engine/paper/reduction.h"
#include "engine/paper/traversal.h"
#include "engine/paper/triangle_set.h"
#include "engine/rounding.h"
#include "engine/search/conclusion.h"

namespace meshgauge {
namespace {

// A query of a usual job takes microseconds; one of a million triangles at equal distances takes longer than this.
constexpr std::chrono::milliseconds kTimeToCertify{70};

constexpr std::chrono::milliseconds kLookInterval{100};
constexpr int kTimePerLook = 10;  // looks take at most about a tenth of the time

// The intersection of two certified intervals of the same distance, with the witness of its lower bound.
Bounds intersection(const Bounds& a, const Bounds& b) {
  Bounds both = b.lower > a.lower ? b : a;
  both.upper = std::min(a.upper, b.upper);
  return both;
}

// Returns the bound of options.strategy. It borrows `search`. Precondition: the strategy is not `automatic`.
std::unique_ptr<PieceBound> make_paper_bound(const Options& options, Search& search) {
  switch (options.strategy) {
    case Strategy::n_point:
      return std::make_unique<NPoint>(search.to(), stencil_level(options.points).value_or(0), search.work(),
                                      search.stop());
    case Strategy::triangle_set:
      return std::make_unique<TriangleSet>(search);
    case Strategy::four_point:
    case Strategy::automatic:
      break;
  }
  return std::make_unique<FourPoint>(search.to(), search.work(), search.stop());
}

}  // namespace

Measurement::Measurement(const Prepared& a, const Prepared& b, const Options& options, Control& control)
    : options_(options),
      control_(control),
      kernels_(find_kernels(options.simd)),
      pool_(options.strategy == Strategy::automatic ? std::max(options.threads, 1U) : 1),
      pair_(a, b) {
  const StageClock clock(outcome_.timings.build);
  enter_frame(pair_, *kernels_, pool_);
  outcome_.simd = kernels_->name;
  outcome_.threads = static_cast<unsigned>(pool_.size());
  outcome_.diagonal_a = diagonal(a.box());
  set_goal();
  if (options.direction != Direction::b_to_a) open(outcome_.a_to_b, pair_.a, pair_.b);
  if (options.direction != Direction::a_to_b) open(outcome_.b_to_a, pair_.b, pair_.a);
}

void Measurement::set_goal() {
  goal_ = goal_of(options_, outcome_.diagonal_a, pair_.frame);
  if (measures_points()) goal_.width = goal_.relative = 0;
  if (options_.max_distance) set_gate(options_.ends(*options_.max_distance).pass);
}

// Lower by what the input error takes, and by the rounding of that: the search only has to get there; conclude()
// decides.
void Measurement::set_gate(double limit) {
  limit_ = limit;
  goal_.gate = pair_.frame.length_to_frame(limit - 2 * pair_.error.value());
  gate_checked_at_ = -1;
}

// One query measures all of a point: without a tolerance a cloud costs no more.
bool Measurement::measures_points() const {
  if (options_.direction == Direction::symmetric) return false;
  return is_cloud(options_.direction == Direction::a_to_b ? pair_.a.given() : pair_.b.given());
}

// The interval before any work: every point of `from` is within the far corner's distance of any point of `to`.
void Measurement::open(std::optional<Directed>& directed, MeasuredMesh& from, MeasuredMesh& to) {
  const Frame& frame = pair_.frame;
  directed.emplace();
  pair_.directions.push_back({*directed, from, to});
  directed->culling.triangles = from.given().triangles.size();
  directed->culling.survivors = directed->culling.triangles;
  const Box box{frame.to_frame(from.prepared.box().low), frame.to_frame(from.prepared.box().high)};
  const double upper = farthest_of_box(box, frame.to_frame(to.given().corner(0, 0)));
  directed->bounds.upper = rounding::scale_up(rounding::add_up(upper, rounding::kDistanceSlack), frame.exponent());
  directed->bounds = pair_.error.widened(directed->bounds);
  floor_ = rounding::kDistanceSlack + pair_.error.cost(frame);
}

Outcome Measurement::run() {
  options_.regions.empty() ? search_whole() : measure_regions(pair_, options_, control_, outcome_);
  if (options_.areas || options_.sides) bound_areas();
  if (options_.statistics) sample();
  return std::move(outcome_);
}

void Measurement::search_whole() {
  conclude(search_all());
  // The gate cannot pass any more: whether it fails is another limit.
  const LimitEnds ends = options_.ends(options_.max_distance.value_or(0));
  if (limit_ && ends.are_apart() && outcome_.stop == Stop::gate_decided && outcome_.lower > *limit_) {
    set_gate(ends.fail);
    if (!gate_decided(limit_, outcome_.lower, outcome_.upper)) conclude(search_anew());
  }
  if (options_.narrow && outcome_.stop == Stop::gate_decided) narrow();
}

std::optional<Stop> Measurement::search_all() {
  auto stop = build_both();
  for (MeasuredDirection& direction : pair_.directions) {
    if (!stop && !direction.settled) stop = measure(direction);
  }
  return stop;
}

// What was dropped because it is below the gate is unknown, so the meshes are built and searched anew with another gate
// or none, from the lower bound on. All intervals hold, so their intersection does.
std::optional<Stop> Measurement::search_anew() {
  std::vector<MeasuredDirection> anew;
  for (const MeasuredDirection& given : pair_.directions) anew.push_back({given.result, given.from, given.to});
  pair_.directions.swap(anew);
  return search_all();
}

// The verdict stays.
void Measurement::narrow() {
  const NarrowingTime time(control_);
  goal_.gate.reset();
  if (!measures_points()) {
    goal_.relative = std::max(goal_.relative, kNarrowRelative);
    goal_.width = std::max(goal_.width, pair_.frame.length_to_frame(kNarrowOfLimit * *options_.max_distance));
  }
  try {
    search_anew();
  } catch (const std::bad_alloc&) {  // the verdict is known without it
  }
  conclude(Stop::gate_decided);
}

std::optional<Stop> Measurement::pulse(const Search& search) {
  if (const auto why = control_.check(); why != Interruption::none) return to_stop(why);
  if (fails_gate(search)) return Stop::gate_decided;
  look(search);
  return std::nullopt;
}

template <class Work>
std::optional<Stop> Measurement::staged(const char* name, double& total_ms, Work&& work) {
  const StageClock clock(total_ms);
  stage_ = name;
  return work();
}

std::optional<Stop> Measurement::build_both() {
  return staged("build", outcome_.timings.build,
                [this] { return build(pair_, options_.strategy, goal_, slack(), pool_, control_); });
}

std::optional<Stop> Measurement::measure(MeasuredDirection& direction) {
  const OrderedMesh& from = direction.rest ? *direction.rest : *direction.from.ordered;
  const OrderedMesh& to = direction.near ? direction.near->mesh : *direction.to.ordered;
  const Bvh& tree = direction.near ? direction.near->tree : *direction.to.tree;
  Search search(from.view(), from.box, tree, goal_, lower_, *this, pool_);
  set_up(search, direction);
  LargeArray<float> bounds;
  if (options_.areas && is_auto()) {
    bounds.assign(from.triangles.size(), std::numeric_limits<float>::infinity());
    search.note_in(bounds);
  }
  const auto stop = is_auto() ? search_auto(search, from, to) : search_paper(search, *direction.from.tree);
  if (!bounds.empty()) keep_bounds(search, from, bounds, direction);
  certify(search, direction.result, from, to);
  return stop;
}

// For the areas.
void Measurement::keep_bounds(const Search& search, const OrderedMesh& from, const LargeArray<float>& bounds,
                              MeasuredDirection& direction) {
  const double left_out = rounding::add_up(direction.left_out, search.upper_slack());
  direction.bounds.assign(from.given, rounding::float_up(left_out));
  for (std::size_t t = 0; t < bounds.size(); ++t) direction.bounds[from.original[t]] = bounds[t];
  if (!direction.first) return;
  float& of_first = direction.bounds[from.original[*direction.first]];  // only a vertex of it may have been searched
  of_first = std::max(of_first, rounding::float_up(left_out));
}

// Without the residual, which is that of a tree.
Slack Measurement::slack() const {
  const Frame& frame = pair_.frame;
  const double output_rounding = frame.length_to_frame(2 * std::numeric_limits<double>::denorm_min());
  return {0, frame.rounding_of_points(), output_rounding + pair_.error.cost(frame), lower_slack_};
}

void Measurement::set_up(Search& search, MeasuredDirection& direction) {
  search.set_options(options_);
  search.set_slack(slack());
  search.drop(direction.left_out);
  if (direction.first) search.measure_corners(*direction.first);
  search.set_reach(direction.reach);
  running_ = &direction.result;
  certifier_ = Certifier();
  search.set_adjacency_source([this, &direction] {
    const Interrupted stop = [this] { return interrupted(); };
    return direction.near ? direction.near->adjacency(pool_, stop) : direction.to.framed->adjacency(pool_, stop);
  });
}

std::optional<Stop> Measurement::search_auto(Search& search, const OrderedMesh& from, const OrderedMesh& to) {
  auto stop = staged("traverse", outcome_.timings.traverse, [&] { return sweep(search, from, to); });
  if (!stop) stop = staged("reduce", outcome_.timings.reduce, [&] { return bisect(search); });
  return stop;
}

std::optional<Stop> Measurement::search_paper(Search& search, const Bvh& from_tree) {
  const auto bound = make_paper_bound(options_, search);
  auto stop = staged("traverse", outcome_.timings.traverse, [&] { return traverse(search, from_tree, *bound); });
  if (!stop) stop = staged("reduce", outcome_.timings.reduce, [&] { return reduce(search, *bound); });
  return stop;
}

void Measurement::certify(const Search& search, Directed& directed, const OrderedMesh& from, const OrderedMesh& to) {
  const StageClock clock(outcome_.timings.certify);
  stage_ = "certify";
  Bounds found = certified(search);
  found.witness->triangle_a = from.original[found.witness->triangle_a];
  found.witness->triangle_b = to.original[found.witness->triangle_b];
  directed.bounds = intersection(found, directed.bounds);
  directed.culling.survivors = search.survivors();
  directed.work += search.work();
  lower_ = std::max(lower_, search.lower());
  lower_slack_ = search.lower_slack();
  floor_ = std::max(floor_, search.slack() + search.unresolved_gap());
}

// A query of certify() that is under way when the job is interrupted, or begins then, has kTimeToCertify.
Bounds Measurement::certified(const Search& search) {
  const Interrupted stop = [this] {
    if (!interrupted_at_ && !interrupted()) return false;
    const auto now = Control::Clock::now();
    if (!interrupted_at_) interrupted_at_ = now;
    return now - *interrupted_at_ >= kTimeToCertify;
  };
  return pair_.error.widened(certifier_.certify(search, pair_.frame, stop));
}

// Certifying costs one query, so it is asked for only when the lower bound has moved.
bool Measurement::fails_gate(const Search& search) {
  if (!search.above_gate()) return false;
  if (search.lower() != gate_checked_at_) {
    gate_checked_at_ = search.lower();
    gate_failed_ = certified(search).lower > *limit_;
  }
  return gate_failed_;
}

// Certifies during the search, so that an interruption finds a certified lower bound although certifying may take
// longer than kTimeToCertify. A report needs it, too.
void Measurement::look(const Search& search) {
  const auto begun = Control::Clock::now();
  const auto since = begun - looked_at_;
  const auto pause = std::max<Control::Clock::duration>(kTimePerLook * look_took_, kLookInterval);
  const bool dear = pause > kLookInterval;
  if (since < pause && (dear || !control_.report_due())) return;
  control_.report_due() ? report(search) : static_cast<void>(certified(search));
  looked_at_ = Control::Clock::now();
  look_took_ = looked_at_ - begun;
}

// Reports the interval as it would be if the search ended now; the stored result stays as it was.
void Measurement::report(const Search& search) {
  const Bounds before = running_->bounds;
  running_->bounds = intersection(certified(search), before);
  take_maximum(outcome_);
  control_.report({outcome_.lower, outcome_.upper, stage_});
  running_->bounds = before;
}

void Measurement::conclude(std::optional<Stop> stop) {
  take_maximum(outcome_);
  outcome_.precision_floor = rounding::scale_up(floor_, pair_.frame.exponent());
  outcome_.met_by = rule_met(options_, outcome_.lower, outcome_.upper, outcome_.diagonal_a);
  if (outcome_.met_by) {
    outcome_.stop = Stop::converged;
  } else if (gate_decided(limit_, outcome_.lower, outcome_.upper)) {
    outcome_.stop = Stop::gate_decided;
  } else {
    outcome_.stop = stop.value_or(Stop::precision_floor);
  }
}

// Reports the final interval while the stages after it run.
std::function<void()> Measurement::teller() {
  return [this] {
    if (control_.report_due()) control_.report({outcome_.lower, outcome_.upper, stage_});
  };
}

void Measurement::bound_areas() {
  const StageClock clock(outcome_.timings.areas);
  stage_ = "areas";
  if (options_.areas) take_areas(pair_, options_, pool_, control_, teller(), outcome_.areas.emplace());
  if (options_.sides) take_sides(pair_, options_, pool_, control_, teller(), outcome_.sides.emplace());
}

// The interval is final here: no failure of the statistics changes it.
void Measurement::sample() {
  const StageClock clock(outcome_.timings.statistics);
  stage_ = "statistics";
  take_statistics(pair_, *options_.statistics, pool_, control_, teller(), outcome_.statistics.emplace());
}

}  // namespace meshgauge
