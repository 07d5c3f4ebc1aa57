// What an interval means for what was asked: which rule holds, whether the gate is decided, why the work ended.
#pragma once

#include <optional>

#include "engine/control.h"
#include "engine/options.h"
#include "engine/outcome.h"

namespace meshgauge {

// Returns the first rule of `tolerance` that the interval [lower, upper] meets; nullopt: none. All in the meshes' unit.
std::optional<Rule> rule_met(const Tolerance& tolerance, double lower, double upper, double diagonal_a);

// Whether upper <= max_distance or lower > max_distance. False without a gate.
bool gate_decided(const std::optional<double>& max_distance, double lower, double upper);

// Sets Outcome::lower and upper to the maximum over the directions that were asked for.
void take_maximum(Outcome& outcome);

// Precondition: the job was interrupted.
inline Stop to_stop(Interruption interruption) {
  return interruption == Interruption::timeout ? Stop::timeout : Stop::cancelled;
}

}  // namespace meshgauge
