#include "engine/extras/statistics/statistics_stage.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <new>
#include <optional>
#include <random>
#include <vector>

#include "engine/extras/statistics/surface_sampler.h"
#include "engine/rounding.h"
#include "engine/tree/nearest.h"

namespace meshgauge {
namespace {

constexpr std::size_t kStrataATask = 16;
constexpr std::size_t kPointsATask = kStrataATask * kPointsAStratum;

// The random generator of one task. It does not depend on the thread or on earlier tasks.
std::mt19937_64 generator(const SampledDirection& direction, std::size_t task) {
  const std::uint64_t seed = direction.sampling.seed;
  std::seed_seq seeds{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), direction.stream,
                      static_cast<std::uint32_t>(task)};
  return std::mt19937_64(seeds);
}

// Sets the distances of one task's points; `point(i)` is called for each in their order. False: interrupted.
template <class Point>
bool run_task(const SampledDirection& direction, const Bvh& to, std::size_t task, std::vector<double>& values,
              const Point& point) {
  std::uint32_t hint = Nearest::kNone;
  std::uint64_t tests = 0;
  const Interrupted stop = [&direction] { return direction.control.check() != Interruption::none; };
  const std::size_t end = std::min((task + 1) * kPointsATask, values.size());
  for (std::size_t i = task * kPointsATask; i < end; ++i) {
    if (stop()) return false;
    const Nearest found = nearest(to, point(i), tests, hint, &stop);
    if (!found.complete) return false;
    values[i] = found.distance > rounding::kDistanceSlack ? found.distance : 0;
    hint = found.slot;
  }
  return true;
}

// `run(task)` sets the distances of one task. False: interrupted.
template <class Run>
bool run_tasks(const SampledDirection& direction, std::size_t points, const Run& run) {
  std::atomic<bool> stopped{direction.control.check() != Interruption::none};
  if (stopped) return false;
  direction.pool.run((points + kPointsATask - 1) / kPointsATask, [&](std::size_t worker, std::size_t task) {
    if (stopped) return;
    if (!run(task)) stopped = true;
    if (worker == 0) direction.tell();
  });
  return !stopped;
}

// Returns the statistics of these distances, in the meshes' unit. `upper`: certified bound of the distance of every
// point of `from`, in that unit; larger distances, which rounding can cause, are reduced to it. nullopt: interrupted.
std::optional<Distribution> distribution(const SampledDirection& direction, double upper) {
  auto sampled = sample_distances(direction);
  if (!sampled) return std::nullopt;
  const Frame& frame = direction.from.frame();
  for (double& value : sampled->values) value = std::min(value, frame.length_to_frame(upper));
  Distribution found = sampled->all ? summarize_all(sampled->values) : summarize(sampled->values);
  found.weight = sampled->weight;
  const int exponent = frame.exponent();
  found.max_seen = std::min(std::ldexp(found.max_seen, exponent), upper);
  for (Estimate* length : {&found.mean, &found.rms, &found.p50, &found.p95, &found.p99}) {
    length->value = std::min(std::ldexp(length->value, exponent), found.max_seen);
    length->standard_error = std::ldexp(length->standard_error, exponent);
  }
  return found;
}

StatisticsStatus to_status(Interruption interruption) {
  return interruption == Interruption::timeout ? StatisticsStatus::timeout : StatisticsStatus::cancelled;
}

}  // namespace

std::optional<SampledDistances> sample_distances(const SampledDirection& direction) {
  const OrderedMesh* from = direction.from.order(direction.control, direction.pool);
  const Bvh* to = from ? direction.to.tree(direction.control, direction.pool) : nullptr;
  if (!to) return std::nullopt;
  const MeshView mesh = from->view();
  if (is_cloud(mesh)) {
    SampledDistances found{Weight::points, true, std::vector<double>(mesh.triangles.size())};
    const auto run = [&](std::size_t task) {
      return run_task(direction, *to, task, found.values, [&](std::size_t i) { return mesh.corner(i, 0); });
    };
    if (!run_tasks(direction, found.values.size(), run)) return std::nullopt;
    return found;
  }
  const std::size_t strata = (direction.sampling.samples + kPointsAStratum - 1) / kPointsAStratum;
  const SurfaceSampler sampler(mesh, strata, direction.control);
  SampledDistances found{sampler.weight(), false, std::vector<double>(strata * kPointsAStratum)};
  const auto run = [&](std::size_t task) {
    std::mt19937_64 random = generator(direction, task);
    return run_task(direction, *to, task, found.values,
                    [&](std::size_t i) { return sampler.point(i / kPointsAStratum, random); });
  };
  if (!run_tasks(direction, found.values.size(), run)) return std::nullopt;
  return found;
}

void take_statistics(const MeasuredPair& pair, const Sampling& sampling, ThreadPool& pool, Control& control,
                     const std::function<void()>& tell, Statistics& statistics) {
  statistics.sampling = sampling;
  try {
    for (const MeasuredDirection& direction : pair.directions) {
      const bool from_a = &direction.from == &pair.a;
      const std::uint32_t stream = from_a ? 0 : 1;
      auto& found = from_a ? statistics.a_to_b : statistics.b_to_a;
      found = distribution({*direction.from.framed, *direction.to.framed, sampling, stream, pool, control, tell},
                           direction.result.bounds.upper);
      if (!found) statistics.status = to_status(control.check());
    }
  } catch (const std::bad_alloc&) {
    statistics.status = StatisticsStatus::memory;
  }
}

}  // namespace meshgauge
