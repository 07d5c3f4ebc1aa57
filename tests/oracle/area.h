// An independent bracket of the area's distribution: cells of a subdivision, each with an interval of its distance. It
// shares no code with the engine and works in extended precision.
#pragma once

#include <vector>

#include "engine/mesh.h"

namespace meshgauge::oracle {

struct AreaCell {
  long double low;  // of the distance of every point of the cell
  long double high;
  long double area;
};

// The cells of `from` after `depth` subdivisions of each triangle in four, and those that `limit` passes through after
// `limit_depth`. By the distance of the cell's centroid and its radius. Lengths in the meshes' unit.
std::vector<AreaCell> area_cells(const Mesh& from, const Mesh& to, int depth, long double limit, int limit_depth);

struct AreaBracket {
  long double low;
  long double high;
};
AreaBracket share_beyond(const std::vector<AreaCell>& cells, long double limit);
AreaBracket mean(const std::vector<AreaCell>& cells);
AreaBracket rms(const std::vector<AreaCell>& cells);
// The smallest distance that the share p of the area is within.
AreaBracket quantile(std::vector<AreaCell> cells, long double p);
long double total_area(const std::vector<AreaCell>& cells);

}  // namespace meshgauge::oracle
