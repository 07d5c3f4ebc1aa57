// Exact winding numbers, and an independent bracket of how far a surface reaches on each side of a closed one. It
// shares no code with the engine.
#pragma once

#include <optional>

#include "engine/mesh.h"
#include "oracle/exact.h"

namespace meshgauge::oracle {

// Returns the winding number around p, by exact crossings of a ray with an edge-free direction. nullopt: p is on the
// surface. Precondition: each edge is passed as often in one direction as in the other.
std::optional<int> winding_number(const Point& p, const Surface& closed);

// Six times the enclosed volume.
Dyadic volume6(const Surface& closed);

struct SideBracket {
  long double low = 0;
  long double high = 0;
};
struct SidesBracket {
  SideBracket outside;
  SideBracket inside;
  bool turned = false;  // a point of `from` has a negative winding number: the rest is not specified
};

// Goes best first over cells of `from`, at most `max_splits` times in four. Points nearer than `rounding` are on
// neither side. Lengths in the meshes' unit.
SidesBracket bracket_sides(const Mesh& from, const Mesh& to, std::size_t max_splits, long double rounding);

}  // namespace meshgauge::oracle
