// An independent bracket of the largest distance of the part of a surface in a region, or in none of several: cells of
// a subdivision, in extended precision. It shares no code with the engine.
#pragma once

#include <span>

#include "engine/mesh.h"
#include "engine/region.h"

namespace meshgauge::oracle {

struct RegionBracket {
  long double low = 0;       // the largest distance of a point that surely is in the part; 0: none was found
  long double high = 0;      // of any point that may be
  bool may_be_empty = true;  // no such point was found
  bool is_empty = true;      // no point may be in the part
};

// Splits at most `cells` cells. A point within `slack` of the surface of a region may be inside or outside.
RegionBracket farthest_inside(const Mesh& from, const Mesh& to, const Region& region, long double slack, int cells);
RegionBracket farthest_outside(const Mesh& from, const Mesh& to, std::span<const Region> regions, long double slack,
                               int cells);

}  // namespace meshgauge::oracle
