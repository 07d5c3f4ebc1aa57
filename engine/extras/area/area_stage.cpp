#include "engine/extras/area/area_stage.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <optional>

#include "engine/extras/area/area_search.h"
#include "engine/extras/area/side_search.h"
#include "engine/mesh/topology.h"
#include "engine/search/conclusion.h"

namespace meshgauge {
namespace {

// The squares of longer lengths could overflow. Distances in a frame are below 4; an error, or the upper bound with it,
// is longer where the exact meshes are larger than their rounded ones.
constexpr double kLongest = 4;

// The intervals before any work.
AreaBounds nothing_known(const AreaOptions& asked, double upper, AreaStop stop) {
  AreaBounds bounds;
  bounds.beyond.assign(asked.beyond.size(), {0, 1});
  bounds.quantiles.assign(asked.quantiles.size(), {0, upper});
  if (asked.mean) bounds.mean = bounds.rms = AreaInterval{0, upper};
  bounds.stop = stop;
  return bounds;
}

// Nothing is beyond the certified bound of all distances, and no length exceeds it; rounding it for the frame may have.
AreaBounds within(double upper, const AreaOptions& asked, AreaBounds bounds) {
  for (std::size_t k = 0; k < asked.beyond.size(); ++k) {
    if (asked.beyond[k].distance >= upper) bounds.beyond[k] = {0, 0};
  }
  for (AreaInterval& q : bounds.quantiles) q.upper = std::min(q.upper, upper);
  if (bounds.mean) bounds.mean->upper = std::min(bounds.mean->upper, upper);
  if (bounds.rms) bounds.rms->upper = std::min(bounds.rms->upper, upper);
  return bounds;
}

AreaStop stop_of(Control& control) {
  return control.check() == Interruption::timeout ? AreaStop::timeout : AreaStop::cancelled;
}

// Builds what a search needs. Returns search(AreaDirection), or nothing(reason) when it may not begin.
template <class Search, class Nothing>
auto searched(const MeasuredDirection& direction, const MeasuredPair& pair, const Options& options, ThreadPool& pool,
              Control& control, const std::function<void()>& tell, const Search& search, const Nothing& nothing) {
  const double upper = direction.result.bounds.upper;
  if (upper == 0) return nothing(AreaStop::complete);
  try {
    const OrderedMesh* from = direction.from.framed->order(control, pool);
    const OrderedMesh* to_mesh = from ? direction.to.framed->order(control, pool) : nullptr;
    const Bvh* to = to_mesh ? direction.to.framed->tree(control, pool) : nullptr;
    const Interrupted late = [&control] { return control.check() != Interruption::none; };
    const Adjacency* adjacency = to ? direction.to.framed->adjacency(pool, late) : nullptr;
    if (!adjacency) return nothing(stop_of(control));
    const double error = pair.error.value() > 0 ? pair.frame.length_to_frame_up(pair.error.value()) : 0;
    const double most = pair.frame.length_to_frame_up(upper);
    if (!(most <= kLongest && error <= kLongest)) return nothing(AreaStop::precision_floor);
    return search(AreaDirection{*from, *to_mesh, *to, *adjacency, pair.frame, options, most, upper, error,
                                direction.bounds, pool, control, tell});
  } catch (const std::bad_alloc&) {
    return nothing(AreaStop::budget);
  }
}

}  // namespace

std::optional<NoSides> refusal_of(const Topology& topology) {
  using Why = NoSides::Why;
  const auto edge = [](Why why, const EdgeCount& count) { return NoSides{why, count.first}; };
  if (topology.open.count > 0) return edge(Why::open, topology.open);
  if (topology.non_manifold.count > 0) return edge(Why::non_manifold, topology.non_manifold);
  if (topology.flipped.count > 0) return edge(Why::flipped, topology.flipped);
  if (!topology.volume || (topology.volume->lower <= 0 && topology.volume->upper >= 0))
    return NoSides{Why::no_volume, std::nullopt};
  return topology.volume->upper < 0 ? std::optional(NoSides{Why::inside_out, std::nullopt}) : std::nullopt;
}

namespace {

// The time from now that the first of two directions has, with a deadline: what is left, but for a half of the
// share of the second, by triangles. So a first one that needs more than its share can have it.
std::optional<Control::Clock::duration> time_of_first(const MeasuredPair& pair, const Control& control) {
  if (!control.deadline() || pair.directions.size() < 2) return std::nullopt;
  double all = 0;
  for (const MeasuredDirection& d : pair.directions) all += static_cast<double>(d.from.given().triangles.size());
  const double of_second = static_cast<double>(pair.directions[1].from.given().triangles.size()) / all;
  const auto left = *control.deadline() - Control::Clock::now();
  return std::chrono::duration_cast<Control::Clock::duration>((1 - of_second / 2) * left);
}

}  // namespace

void take_areas(const MeasuredPair& pair, const Options& options, ThreadPool& pool, Control& control,
                const std::function<void()>& tell, AreaOutcome& found) {
  found.options = *options.areas;
  const auto bounds_of = [&](const MeasuredDirection& direction) -> std::optional<AreaBounds>& {
    return &direction.from == &pair.a ? found.a_to_b : found.b_to_a;
  };
  const auto take = [&](const MeasuredDirection& direction) {
    const double upper = direction.result.bounds.upper;
    return within(upper, *options.areas,
                  searched(
                      direction, pair, options, pool, control, tell,
                      [](const AreaDirection& ready) { return AreaSearch(ready).run(); },
                      [&](AreaStop stop) { return nothing_known(*options.areas, upper, stop); }));
  };
  const auto of_first = time_of_first(pair, control);
  for (const MeasuredDirection& direction : pair.directions) {
    std::optional<EarlierDeadline> earlier;
    if (of_first && &direction == &pair.directions.front()) earlier.emplace(control, Control::Clock::now() + *of_first);
    bounds_of(direction) = take(direction);
  }
}

void take_sides(const MeasuredPair& pair, const Options& options, ThreadPool& pool, Control& control,
                const std::function<void()>& tell, SideOutcome& found) {
  const auto direction = std::find_if(pair.directions.begin(), pair.directions.end(),
                                      [&](const MeasuredDirection& d) { return &d.from == &pair.a; });
  const double upper = direction->result.bounds.upper;
  const auto nothing = [&](AreaStop stop) {
    SideOutcome none;
    none.options = *options.sides;
    none.outside.upper = none.inside.upper = upper;
    none.stop = stop;
    return none;
  };
  found = nothing(AreaStop::budget);
  try {
    const auto known =
        topology(pair.b.given(), pair.b.prepared.box(), [&control] { return control.check() != Interruption::none; });
    if (!known) {
      found = nothing(stop_of(control));
    } else if (const auto refused = refusal_of(*known)) {
      found.refused = refused;
      found.stop = AreaStop::complete;
    } else {
      found = searched(
          *direction, pair, options, pool, control, tell,
          [&](const AreaDirection& ready) { return search_sides(ready, *options.sides); }, nothing);
    }
  } catch (const std::bad_alloc&) {  // topology
  }
}

}  // namespace meshgauge
