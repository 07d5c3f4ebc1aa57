// The kinds of pairs that the generator starts from, before it moves, scales and distorts them.
#pragma once

#include <span>

#include "fuzz/dice.h"
#include "fuzz/generate.h"

namespace meshgauge::fuzz {

struct Kind {
  const char* name;
  void (*make)(Dice& dice, Pair& pair);
};

std::span<const Kind> kinds();

// Small helpers of kinds.cpp and generate.cpp.
void add_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c);
Vec3 one_ulp_away(Dice& dice, const Vec3& p);

}  // namespace meshgauge::fuzz
