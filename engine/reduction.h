// The reduction (paper, Algorithm 3): split the piece with the largest upper bound in four, until a rule holds.
#pragma once

#include <optional>

#include "engine/search.h"

namespace meshgauge {

// Works until search.reached_goal(), or returns the reason why not: the monitor's, or Stop::budget.
std::optional<Stop> reduce(Search& search, PieceBound& bound);

}  // namespace meshgauge
