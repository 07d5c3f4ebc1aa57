// The reduction (paper, Algorithm 3): split the piece with the largest upper bound in four, until a rule holds.
#pragma once

#include <optional>

#include "engine/search.h"

namespace meshgauge {

// Works until search.reached_goal(), or returns the reason why not: the monitor's, or Stop::budget when the pieces that
// wait need more than options.max_memory_bytes or options.max_work_items have been split.
std::optional<Stop> reduce(Search& search, PieceBound& bound, const Options& options);

}  // namespace meshgauge
