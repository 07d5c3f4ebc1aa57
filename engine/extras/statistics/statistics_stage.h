// The last stage of a measurement: distances from sampled points of one mesh to the other, and their statistics, once
// the interval is final.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/control.h"
#include "engine/search/measured_pair.h"
#include "engine/statistics.h"
#include "engine/thread_pool.h"
#include "engine/tree/prepared.h"

namespace meshgauge {

// The input of sampling in one direction.
struct SampledDirection {
  Framed& from;
  Framed& to;  // in the same frame
  Sampling sampling;
  std::uint32_t stream;  // random stream: a different number for each direction
  ThreadPool& pool;
  Control& control;                   // polled before every point
  const std::function<void()>& tell;  // called after each task of this thread, to report progress
};

struct SampledDistances {
  Weight weight = Weight::area;  // of `from`
  bool all = false;              // `from` is a cloud, and each of its points was measured
  std::vector<double> values;    // in the order of summarize(), in frame units; 0 if it could be rounding alone
};

// Returns the distances; they do not depend on the pool. nullopt: `control` interrupted it.
std::optional<SampledDistances> sample_distances(const SampledDirection& direction);

// Samples each direction of `pair` and fills `statistics`. On a deadline, a cancellation or lack of memory it sets
// `status` and keeps the directions that were done; it does not throw std::bad_alloc. Calls `tell` repeatedly, on this
// thread, to report progress.
void take_statistics(const MeasuredPair& pair, const Sampling& sampling, ThreadPool& pool, Control& control,
                     const std::function<void()>& tell, Statistics& statistics);

}  // namespace meshgauge
