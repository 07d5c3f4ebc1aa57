#include "engine/area/area_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "engine/area/area_search.h"

namespace meshgauge {
namespace {

// Rounded up. Beyond the frame's size, every length is as good as any other.
double length_to_frame_up(const Frame& frame, double length) {
  const double nearest = frame.length_to_frame(length);
  return std::min(std::nextafter(nearest, std::numeric_limits<double>::infinity()), 4.0);
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

// No length exceeds the certified bound of all distances; rounding it for the frame may have.
AreaBounds within(double upper, AreaBounds bounds) {
  for (AreaInterval& q : bounds.quantiles) q.upper = std::min(q.upper, upper);
  if (bounds.mean) bounds.mean->upper = std::min(bounds.mean->upper, upper);
  if (bounds.rms) bounds.rms->upper = std::min(bounds.rms->upper, upper);
  return bounds;
}

AreaBounds bounds_of(const MeasuredDirection& direction, const MeasuredPair& pair, const Options& options,
                     ThreadPool& pool, Control& control, const std::function<void()>& tell) {
  const double upper = direction.result.bounds.upper;
  try {
    const OrderedMesh* from = direction.from.framed->order(control, pool);
    const Bvh* to = from ? direction.to.framed->tree(control, pool) : nullptr;
    if (!to) {
      const bool is_late = control.check() == Interruption::timeout;
      return nothing_known(*options.areas, upper, is_late ? AreaStop::timeout : AreaStop::cancelled);
    }
    const double error = pair.error.value() > 0 ? length_to_frame_up(pair.frame, pair.error.value()) : 0;
    const double most = length_to_frame_up(pair.frame, upper);
    return within(upper, AreaSearch({*from, *to, pair.frame, options, most, error, pool, control, tell}).run());
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
    bounds = bounds_of(direction, pair, options, pool, control, tell);
  }
}

}  // namespace meshgauge
