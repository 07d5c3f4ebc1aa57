// Pairs of small meshes, random and adversarial, made from a seed alone.
#pragma once

#include <cstdint>
#include <string>

#include "engine/mesh.h"

namespace meshgauge::fuzz {

struct Pair {
  Mesh a;
  Mesh b;
  std::string what;  // the recipe: "slivers, rotated, offset 1e6"
};

// 1 to about 12 triangles a side, some hundred now and then; both pass validate(). Equal seeds give equal pairs.
Pair generate(std::uint64_t seed);

}  // namespace meshgauge::fuzz
