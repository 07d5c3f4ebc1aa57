// Distances from sampled points of one mesh to another mesh, and their statistics.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/control.h"
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

// Returns the statistics of these distances, in the meshes' unit. `upper`: certified bound of the distance of every
// point of `from`, in that unit; larger distances, which rounding can cause, are reduced to it. nullopt: interrupted.
std::optional<Distribution> distribution(const SampledDirection& direction, double upper);

}  // namespace meshgauge
