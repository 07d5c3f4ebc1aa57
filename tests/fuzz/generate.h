// Generates pairs of small meshes, random and adversarial, from a seed.
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

// Returns a pair of meshes with 1 to about 12 triangles each, rarely some hundred. Both pass validate(). Equal seeds
// give equal pairs.
Pair generate(std::uint64_t seed);

// Writes it to stdout as OBJ, with all digits, under a heading.
void print_obj(const Mesh& mesh, const char* heading);

}  // namespace meshgauge::fuzz
