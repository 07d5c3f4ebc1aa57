// One attack on meshes in other units: converts and measures both, and checks the interval with the exact surfaces.
#pragma once

#include <cstddef>
#include <optional>

#include "engine/hausdorff.h"
#include "fuzz/dice.h"
#include "fuzz/generate.h"
#include "oracle/judge.h"

namespace meshgauge::fuzz {

// Converts both meshes by the factors of two random units, and measures. Checks in each direction, in exact arithmetic
// on the surfaces times their factors:
//   converted upper   no sample is farther than upper
//   converted lower   the exact bracket does not end below lower; not checked if effort.max_splits is 0
// Returns the violation. nullopt: all holds, or a coordinate is too large for the unit.
std::optional<oracle::Violation> attack_converted(const Pair& pair, const Options& options,
                                                  const oracle::Effort& effort, Dice& dice);

}  // namespace meshgauge::fuzz
