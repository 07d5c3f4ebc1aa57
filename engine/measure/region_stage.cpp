#include "engine/measure/region_stage.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "engine/measure/measurement.h"
#include "engine/mesh/clipping.h"
#include "engine/search/conclusion.h"

namespace meshgauge {
namespace {

// What cutting at a sphere may add to either end of an interval, of the width asked for.
constexpr double kResolution = 0.125;
constexpr double kCoarse = 0x1p-10;            // of a limit, as long as the gate is decided with it
constexpr double kOfSphere = 0x1p-6;           // of its radius
constexpr double kLeastResolution = 0x1p-33;   // of the diagonal of both meshes: bounds the number of pieces
constexpr double kCoarsestPosition = 0x1p-46;  // of the largest coordinate: pieces are wider than their rounding
constexpr double kLeastLength = 0x1p-1050;

int weight(Stop stop) {
  constexpr Stop kOrder[] = {Stop::converged, Stop::gate_decided, Stop::precision_floor,
                             Stop::budget,    Stop::timeout,      Stop::cancelled};
  return static_cast<int>(std::find(std::begin(kOrder), std::end(kOrder), stop) - std::begin(kOrder));
}

Stop worse(Stop a, Stop b) { return weight(a) < weight(b) ? b : a; }

Timings& operator+=(Timings& sum, const Timings& more) {
  sum.build += more.build;
  sum.traverse += more.traverse;
  sum.reduce += more.reduce;
  sum.certify += more.certify;
  return sum;
}

// The options of the search of one part, one-sided, as if from a to b.
Options of_part(const Options& options, double diagonal_a) {
  Options part = options;
  part.direction = Direction::a_to_b;
  if (const auto share = part.tolerance.diagonal) {
    part.tolerance.absolute = std::max(part.tolerance.absolute.value_or(0), *share * diagonal_a);
    part.tolerance.diagonal.reset();
  }
  part.regions.clear();
  part.areas.reset();
  part.sides.reset();
  part.statistics.reset();
  return part;
}

class RegionStage {
  // While it lives, what is reported of a part is told of the whole: no upper bound is known before the end.
  class Telling {
   public:
    explicit Telling(RegionStage& stage) : control_(stage.control_), before_(control_.exchange_callback(nullptr)) {
      if (!before_) return;
      control_.exchange_callback([this, &stage](const Progress& part) {
        take_maximum(stage.outcome_);
        before_({std::max(part.lower, stage.outcome_.lower), std::max(part.upper, stage.farthest_), part.stage});
      });
    }
    ~Telling() { control_.exchange_callback(before_); }
    Telling(const Telling&) = delete;
    Telling& operator=(const Telling&) = delete;

   private:
    Control& control_;
    const std::function<void(const Progress&)> before_;
  };

 public:
  RegionStage(MeasuredPair& pair, const Options& options, Control& control, Outcome& outcome)
      : pair_(pair),
        options_(options),
        control_(control),
        outcome_(outcome),
        part_options_(of_part(options, outcome.diagonal_a)) {
    std::ranges::remove_copy_if(options.regions, std::back_inserter(of_space_), &Region::is_group);
    Box both = pair.a.prepared.box();
    both.extend(pair.b.prepared.box());
    const double largest = std::max(both.low.cwiseAbs().maxCoeff(), both.high.cwiseAbs().maxCoeff());
    least_resolution_ = std::max({kLeastResolution * diagonal(both), kCoarsestPosition * largest, kLeastLength});
    for (const MeasuredDirection& direction : pair_.directions) {
      farthest_ = std::max(farthest_, direction.result.bounds.upper);
      direction.result.bounds.upper = 0;
      direction.result.culling = {};
    }
  }

  void run() {
    const Telling telling(*this);
    const std::span<const Region> regions = options_.regions;
    for (const Region& region : regions) add(measure({&region, 1}, Keep::inside, region.max_distance));
    add(measure(regions, Keep::outside, std::nullopt));
    take_maximum(outcome_);
    outcome_.met_by = rule_met(options_, outcome_.lower, outcome_.upper, outcome_.diagonal_a);
    if (outcome_.met_by) {
      outcome_.stop = Stop::converged;
      return;
    }
    for (const RegionOutcome& found : outcome_.regions)
      outcome_.precision_floor = std::max(outcome_.precision_floor, found.precision_floor);
  }

 private:
  // Measures a part of both meshes, in each direction asked for. A gate is first tried with a coarse cut.
  RegionOutcome measure(std::span<const Region> regions, Keep keep, const std::optional<double>& own_limit) {
    const auto limit = part_options_.max_distance = own_limit ? own_limit : options_.max_distance;
    const double fine = kResolution * part_options_.tolerance.absolute.value_or(0);
    const double coarse = limit ? std::max(fine, kCoarse * std::min(*limit, farthest_)) : fine;
    RegionOutcome found = measure(regions, keep, resolution(regions, coarse));
    if (!limit || is_decided(found)) return found;
    const bool is_over = weight(found.stop) >= weight(Stop::budget);
    return coarse > fine && !is_over ? measure(regions, keep, resolution(regions, fine)) : found;
  }

  // As wished, but far smaller than a sphere, and not below what bounds the number of pieces.
  double resolution(std::span<const Region> regions, double wished) const {
    for (const Region& region : regions) {
      if (const auto* sphere = std::get_if<Sphere>(&region.shape))
        wished = std::min(wished, kOfSphere * sphere->radius);
    }
    return std::max(wished, least_resolution_);
  }

  // Whether the gate passes or fails, or is known to stay open between the ends of its limit.
  bool is_decided(const RegionOutcome& found) const {
    const auto& limit = part_options_.max_distance;
    const auto decided = [&](double at) { return gate_decided(at, found.lower, found.upper); };
    if (!limit) return false;
    const LimitEnds ends = options_.ends(*limit);
    return decided(ends.pass) && decided(ends.fail);
  }

  // The searches ended by a rule or the gate, which may not hold of them together: doubtful triangles count for the
  // upper bound alone.
  void conclude(RegionOutcome& found) const {
    if (found.empty || weight(found.stop) > weight(Stop::precision_floor)) return;
    if (rule_met(part_options_, found.lower, found.upper, outcome_.diagonal_a)) {
      found.stop = Stop::converged;
    } else if (is_decided(found)) {
      found.stop = Stop::gate_decided;
    } else if (found.stop != Stop::precision_floor) {
      found.stop = Stop::precision_floor;
      found.precision_floor = std::max(found.precision_floor, found.upper - found.lower);
    }
  }

  RegionOutcome measure(std::span<const Region> regions, Keep keep, double resolution) {
    RegionOutcome found;
    for (MeasuredDirection& direction : pair_.directions) {
      const bool from_a = &direction.from == &pair_.a;
      if (from_a && keep == Keep::inside && regions.front().is_group()) continue;
      const std::span<const Region> of_mesh = from_a && keep == Keep::outside ? of_space_ : regions;
      auto& bounds = from_a ? found.a_to_b : found.b_to_a;
      bounds = measure(direction, cut(direction.from.prepared, of_mesh, keep, resolution), found);
      found.lower = std::max(found.lower, bounds->lower);
      found.upper = std::max(found.upper, bounds->upper);
    }
    return found;
  }

  // Takes a part into the bounds of the whole.
  void add(RegionOutcome found) {
    for (MeasuredDirection& direction : pair_.directions) {
      const auto& bounds = &direction.from == &pair_.a ? found.a_to_b : found.b_to_a;
      if (!bounds) continue;
      Bounds& whole = direction.result.bounds;
      if (bounds->witness && (!whole.witness || bounds->lower > whole.lower)) whole.witness = bounds->witness;
      whole.lower = std::max(whole.lower, bounds->lower);
      whole.upper = std::max(whole.upper, bounds->upper);
    }
    outcome_.precision_floor = std::max(outcome_.precision_floor, found.precision_floor);
    conclude(found);
    outcome_.stop = worse(outcome_.stop, found.stop);
    outcome_.regions.push_back(found);
  }

  Bounds measure(MeasuredDirection& direction, const std::optional<RegionPart>& part, RegionOutcome& found) {
    const Prepared &from = direction.from.prepared, &to = direction.to.prepared;
    if (!part) {
      found.empty = false;
      found.stop = worse(found.stop, to_stop(control_.check()));
      return {0, farthest_, std::nullopt};
    }
    if (part->whole) return search(from, to, direction.result, found);
    Bounds bounds = search(part->sure, to, direction.result, found);
    const Bounds doubtful = search(part->doubtful, to, direction.result, found);
    bounds.upper = std::max(bounds.upper, doubtful.upper);  // it may have no point of the part
    return bounds;
  }

  std::optional<RegionPart> cut(const Prepared& from, std::span<const Region> regions, Keep keep, double resolution) {
    const StageClock clock(outcome_.timings.build);
    return part_of(from.mesh(), from.error(), regions, keep, resolution,
                   [this] { return control_.check() != Interruption::none; });
  }

  Bounds search(const PartMesh& part, const Prepared& to, Directed& total, RegionOutcome& found) {
    if (part.mesh.triangles.empty()) return {};
    Bounds bounds =
        search(Prepared(part.mesh, Prepared::Use::once, nullptr, std::nullopt, part.error), to, total, found);
    if (bounds.witness) bounds.witness->triangle_a = part.original[bounds.witness->triangle_a];
    return bounds;
  }

  Bounds search(const Prepared& from, const Prepared& to, Directed& total, RegionOutcome& found) {
    part_options_.max_work_items = options_.max_work_items - std::min(options_.max_work_items, total.work.subdivisions);
    const Outcome outcome = Measurement(from, to, part_options_, control_).run();
    found.empty = false;
    found.stop = worse(found.stop, outcome.stop);
    found.precision_floor = std::max(found.precision_floor, outcome.precision_floor);
    total.work += outcome.a_to_b->work;
    total.culling.triangles += outcome.a_to_b->culling.triangles;
    total.culling.survivors += outcome.a_to_b->culling.survivors;
    outcome_.timings += outcome.timings;
    outcome_.threads = std::max(outcome_.threads, outcome.threads);
    return outcome.a_to_b->bounds;
  }

  MeasuredPair& pair_;
  const Options& options_;
  Control& control_;
  Outcome& outcome_;
  Options part_options_;
  std::vector<Region> of_space_;  // the regions that mesh a has points in
  double least_resolution_ = 0;
  double farthest_ = 0;  // of the whole before any work
};

}  // namespace

void measure_regions(MeasuredPair& pair, const Options& options, Control& control, Outcome& outcome) {
  RegionStage(pair, options, control, outcome).run();
}

}  // namespace meshgauge
