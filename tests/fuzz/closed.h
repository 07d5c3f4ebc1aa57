// Generates pairs of small meshes whose mesh b is closed and oriented, from a seed.
#pragma once

#include <cstdint>

#include "fuzz/generate.h"

namespace meshgauge::fuzz {

// Mesh b: solids, bent ones that cross themselves, unions that overlap, cavities, slabs, triangles of no area; parts or
// all of it may face inwards. Mesh a: open and closed surfaces and clouds beside, across, on and within it. At most
// some 100 triangles each.
Pair generate_closed(std::uint64_t seed);

}  // namespace meshgauge::fuzz
