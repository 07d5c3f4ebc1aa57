// Sorts the triangles of A by the limits of shares, most of them without a query of their own.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/extras/area/area_search.h"
#include "engine/mesh/large_array.h"

namespace meshgauge {

// Where a triangle P of the exact mesh A lies.
enum class Place : std::uint8_t {
  within,   // h(P, B) <= `low`
  beyond,   // d(x, B) > `high` for all x in P
  unknown,  // neither is known
};

// Returns the place of each triangle of `direction.from`; lengths in frame units. nullopt: interrupted.
std::optional<LargeArray<Place>> places_of(const AreaDirection& direction, double low, double high);

}  // namespace meshgauge
