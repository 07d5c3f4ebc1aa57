// The reduction (paper, Algorithm 3): split the piece with the largest upper bound in four, until a rule holds.
#pragma once

#include <optional>

#include "engine/search/search.h"

namespace meshgauge {

// Splits the pieces that wait in `search`. Returns nullopt: search.reached_goal() or no piece is left; else the reason
// to stop, the monitor's or Stop::budget.
std::optional<Stop> reduce(Search& search, PieceBound& bound);

}  // namespace meshgauge
