#include "engine/area/area_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "engine/area/area_search.h"

namespace meshgauge {
namespace {

// The squares of longer lengths could overflow. Distances in a frame are below 4; an error, or the upper bound with it,
// is longer where the exact meshes are larger than their rounded ones.
constexpr double kLongest = 4;

double length_to_frame_up(const Frame& frame, double length) {
  return std::nextafter(frame.length_to_frame(length), std::numeric_limits<double>::infinity());
}

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

AreaBounds bounds_of(const MeasuredDirection& direction, const MeasuredPair& pair, const Options& options,
                     ThreadPool& pool, Control& control, const std::function<void()>& tell) {
  const double upper = direction.result.bounds.upper;
  if (upper == 0) return nothing_known(*options.areas, 0, AreaStop::complete);
  try {
    const OrderedMesh* from = direction.from.framed->order(control, pool);
    const OrderedMesh* to_mesh = from ? direction.to.framed->order(control, pool) : nullptr;
    const Bvh* to = to_mesh ? direction.to.framed->tree(control, pool) : nullptr;
    const Interrupted late = [&control] { return control.check() != Interruption::none; };
    const Adjacency* adjacency = to ? direction.to.framed->adjacency(pool, late) : nullptr;
    if (!adjacency) {
      const bool is_late = control.check() == Interruption::timeout;
      return nothing_known(*options.areas, upper, is_late ? AreaStop::timeout : AreaStop::cancelled);
    }
    const double error = pair.error.value() > 0 ? length_to_frame_up(pair.frame, pair.error.value()) : 0;
    const double most = length_to_frame_up(pair.frame, upper);
    if (!(most <= kLongest && error <= kLongest))
      return nothing_known(*options.areas, upper, AreaStop::precision_floor);
    return AreaSearch({*from, *to_mesh, *to, *adjacency, pair.frame, options, most, upper, error, pool, control, tell})
        .run();
  } catch (const std::bad_alloc&) {
    return nothing_known(*options.areas, upper, AreaStop::budget);
  }
}

}  // namespace

void take_areas(const MeasuredPair& pair, const Options& options, ThreadPool& pool, Control& control,
                const std::function<void()>& tell, AreaOutcome& found) {
  found.options = *options.areas;
  for (const MeasuredDirection& direction : pair.directions) {
    auto& bounds = &direction.from == &pair.a ? found.a_to_b : found.b_to_a;
    bounds =
        within(direction.result.bounds.upper, *options.areas, bounds_of(direction, pair, options, pool, control, tell));
  }
}

}  // namespace meshgauge
