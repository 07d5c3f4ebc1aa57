#include "engine/extras/area/vertices.h"

#include <algorithm>
#include <atomic>

#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

constexpr std::size_t kVerticesATask = 256;
constexpr std::size_t kTasksAGrowth = 256;  // for which memory is touched at once

}  // namespace

// A task starts without a hint, so that the distances do not depend on the threads.
bool measure_vertices(const AreaDirection& direction, const std::optional<std::vector<std::uint32_t>>& rest,
                      LargeArray<Corner>& corners) {
  const Interrupted stop = [&direction] { return direction.control.check() != Interruption::none; };
  const std::size_t count = direction.from.positions.size();
  std::vector<bool> used(count, !rest);
  const bool is_whole = each_unless(stop, rest ? rest->size() : 0, [&](std::size_t i) {
    for (const std::uint32_t v : direction.from.triangles[(*rest)[i]]) used[v] = true;
  });
  if (!is_whole) return false;
  corners.reserve(count);
  std::atomic<bool> stopped{false};
  for (std::size_t begin = 0; begin < count && !stopped; begin = corners.size()) {
    corners.resize(std::min(count, begin + kTasksAGrowth * kVerticesATask));
    direction.pool.run(tasks_for(corners.size() - begin, kVerticesATask), [&](std::size_t, std::size_t task) {
      if (stopped || stop()) stopped = true;
      Work work;
      std::uint32_t hint = Nearest::kNone;
      const std::size_t first = begin + task * kVerticesATask;
      for (std::size_t v = first; v < std::min(corners.size(), first + kVerticesATask) && !stopped; ++v) {
        if (!used[v]) continue;
        corners[v] = nearest_corner(direction.to, direction.from.positions[v], work, &stop, hint);
        hint = corners[v].slot;
        if (!corners[v].complete) stopped = true;
      }
    });
  }
  return !stopped;
}

}  // namespace meshgauge
