// The distances of the vertices of A from B.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/extras/area/area_search.h"
#include "engine/mesh/large_array.h"
#include "engine/search/piece.h"

namespace meshgauge {

// Measures the vertices of the triangles in `rest`, ascending; nullopt: of all. The others keep Corner(). The result
// does not depend on the threads. False: interrupted.
bool measure_vertices(const AreaDirection& direction, const std::optional<std::vector<std::uint32_t>>& rest,
                      LargeArray<Corner>& corners);

// The tasks that `count` items make, `each` a task.
inline std::size_t tasks_for(std::size_t count, std::size_t each) { return (count + each - 1) / each; }

}  // namespace meshgauge
