// One attack on meshes in other units: both are converted, measured, and the interval is held against the exact
// surfaces.
#pragma once

#include <cstddef>
#include <optional>

#include "engine/hausdorff.h"
#include "fuzz/dice.h"
#include "fuzz/generate.h"
#include "oracle/judge.h"

namespace meshgauge::fuzz {

// Converts the meshes of the pair by factors of two of the units, drawn by the dice, and measures. Checked in exact
// arithmetic, of the surfaces times their factors, in each direction:
//   converted upper   no sample is farther than upper
//   converted lower   the exact bracket does not end below lower; with `effort.max_splits` of 0 it is not asked
// nullopt: all holds, or a coordinate is too large for the unit.
std::optional<oracle::Violation> attack_converted(const Pair& pair, const Options& options,
                                                  const oracle::Effort& effort, Dice& dice);

}  // namespace meshgauge::fuzz
