// What an interval means for what was asked: which rule holds, and whether the gate is decided.
#pragma once

#include <optional>

#include "engine/options.h"
#include "engine/outcome.h"

namespace meshgauge {

// The first rule of `tolerance` that the interval meets.
std::optional<Rule> rule_met(const Tolerance& tolerance, double lower, double upper, double diagonal_a);

bool gate_decided(const std::optional<double>& max_distance, double lower, double upper);

// Outcome::lower and upper from the directions that are there.
void take_maximum(Outcome& outcome);

}  // namespace meshgauge
