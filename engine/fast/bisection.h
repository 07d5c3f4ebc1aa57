// The second phase of strategy `auto`: bisects the longest edges of the pieces that survive, and uses every bound.
//
// It goes best first while the lower bound rises, because that finds the maximum quickly. Once the lower bound has
// settled the order no longer matters: it goes depth first, each thread with its own stack, and memory stays small.
#pragma once

#include <optional>

#include "engine/search/search.h"

namespace meshgauge {

// Returns nullopt: no piece is left that could exceed the lower bound by more than the tolerance; else the reason to
// stop, the monitor's or Stop::budget. Uses all threads of the search's pool.
std::optional<Stop> bisect(Search& search);

}  // namespace meshgauge
