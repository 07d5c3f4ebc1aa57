// Attacks on what is measured beside the distance. Each tries pairs seed to seed + pairs - 1, prints a summary or the
// first violation, and returns whether there was none.
#pragma once

#include <cstdint>

namespace meshgauge::fuzz {

bool attack_areas(std::uint64_t pairs, std::uint64_t seed);
bool attack_regions(std::uint64_t pairs, std::uint64_t seed);
bool attack_sides(std::uint64_t pairs, std::uint64_t seed);

}  // namespace meshgauge::fuzz
