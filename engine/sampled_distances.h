// Distances from sampled points of one mesh to another mesh: what statistics are made of.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/control.h"
#include "engine/prepared.h"
#include "engine/statistics.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// One direction, and what its sampling may use.
struct SampledDirection {
  Framed& from;
  Framed& to;  // in the same frame
  Sampling sampling;
  std::uint32_t stream;  // a number of its own makes a direction independent of the other
  ThreadPool& pool;
  Control& control;                   // asked before every point
  const std::function<void()>& tell;  // called now and then, on this thread
};

struct SampledDistances {
  Weight weight = Weight::area;  // of `from`
  std::vector<double> values;    // as summarize() takes them, in frame units; what may be rounding alone is 0
};

// The same numbers whatever the pool. None: `control` said to stop.
std::optional<SampledDistances> sample_distances(const SampledDirection& direction);

// What they look like, in the meshes' unit. `upper` bounds the distance of every point of `from`, in that unit; what
// rounding may have put above it is taken off. None: interrupted.
std::optional<Distribution> distribution(const SampledDirection& direction, double upper);

}  // namespace meshgauge
