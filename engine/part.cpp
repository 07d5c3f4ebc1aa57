#include "engine/part.h"

#include <algorithm>
#include <array>

#include "engine/conclusion.h"

namespace meshgauge {
namespace {

constexpr std::size_t kRunsAPart = 32;  // sizes of parts differ by one run at most
constexpr std::size_t kAligned = 64;    // triangles that the sweep looks at together; a run is a multiple, if it can be

std::size_t run_length(std::size_t triangles, unsigned count) {
  const std::size_t length = triangles / (kRunsAPart * count);
  return length < kAligned ? std::max<std::size_t>(length, 1) : length - length % kAligned;
}

// Calls visit(begin, end) for each run of the part, in order.
template <class Visit>
void each_run(std::size_t triangles, const Part& part, const Visit& visit) {
  const std::size_t length = run_length(triangles, part.count);
  for (std::size_t begin = part.index * length; begin < triangles; begin += part.count * length) {
    visit(begin, std::min(begin + length, triangles));
  }
}

// Why the work ended, of all the parts that did not do all that was asked. The first of these that occurs is the
// caller's or the machine's doing, the last the meshes'.
Stop reason(std::span<const Outcome> parts) {
  for (const Stop stop : {Stop::cancelled, Stop::timeout, Stop::budget}) {
    if (std::any_of(parts.begin(), parts.end(), [&](const Outcome& part) { return part.stop == stop; })) return stop;
  }
  return Stop::precision_floor;
}

void join(std::optional<Directed>& whole, const std::optional<Directed>& part) {
  if (!part) return;
  if (!whole) {
    whole = part;
    return;
  }
  Bounds& bounds = whole->bounds;
  // Of equal ones the first; a part without triangles has no witness.
  const bool is_better = part->bounds.lower > bounds.lower || !bounds.witness;
  if (part->bounds.witness && is_better) bounds.witness = part->bounds.witness;
  bounds.lower = std::max(bounds.lower, part->bounds.lower);
  bounds.upper = std::max(bounds.upper, part->bounds.upper);
  whole->culling.triangles += part->culling.triangles;
  whole->culling.survivors += part->culling.survivors;
  whole->work += part->work;
}

void join(Timings& whole, const Timings& part) {
  for (double Timings::*stage :
       {&Timings::build, &Timings::traverse, &Timings::reduce, &Timings::certify, &Timings::statistics}) {
    whole.*stage = std::max(whole.*stage, part.*stage);
  }
}

}  // namespace

Share share_of(const Part& part, Direction direction, std::size_t triangles_a, std::size_t triangles_b) {
  if (direction != Direction::symmetric || part.count == 1) return {direction, part};
  const std::size_t all = triangles_a + triangles_b;
  const auto of_a = static_cast<unsigned>((part.count * triangles_a + all / 2) / all);
  const unsigned first = std::clamp(of_a, 1U, part.count - 1);
  if (part.index < first) return {Direction::a_to_b, {part.index, first}};
  return {Direction::b_to_a, {part.index - first, part.count - first}};
}

LargeArray<std::uint32_t> of_part(std::span<const std::uint32_t> order, const Part& part) {
  LargeArray<std::uint32_t> chosen;
  chosen.reserve(size_of_part(order.size(), part));
  each_run(order.size(), part, [&](std::size_t begin, std::size_t end) {
    const auto run = order.subspan(begin, end - begin);
    chosen.insert(chosen.end(), run.begin(), run.end());
  });
  return chosen;
}

std::size_t size_of_part(std::size_t triangles, const Part& part) {
  std::size_t size = 0;
  each_run(triangles, part, [&](std::size_t begin, std::size_t end) { size += end - begin; });
  return size;
}

Outcome joined(std::span<const Outcome> parts, const Options& options) {
  Outcome whole = parts.front();
  for (const Outcome& part : parts.subspan(1)) {
    join(whole.a_to_b, part.a_to_b);
    join(whole.b_to_a, part.b_to_a);
    whole.precision_floor = std::max(whole.precision_floor, part.precision_floor);
    whole.threads = std::max(whole.threads, part.threads);
    join(whole.timings, part.timings);
  }
  take_maximum(whole);
  whole.met_by = rule_met(options.tolerance, whole.lower, whole.upper, whole.diagonal_a);
  const bool decided = gate_decided(options.max_distance, whole.lower, whole.upper);
  whole.stop = whole.met_by ? Stop::converged : decided ? Stop::gate_decided : reason(parts);
  return whole;
}

bool relies_on_lost(const Outcome& joined) {
  return joined.stop == Stop::precision_floor && joined.upper - joined.lower > joined.precision_floor;
}

}  // namespace meshgauge
