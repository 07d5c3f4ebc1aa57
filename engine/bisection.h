// The second phase of strategy `auto`: bisect the longest edge of what survives, with every bound there is.
//
// Best first while the lower bound moves, because only that finds it quickly; depth first once it has settled, because
// the order no longer matters: all threads then work at stacks of their own, and memory stays flat.
#pragma once

#include <optional>

#include "engine/search.h"

namespace meshgauge {

// Works until nothing is left that could exceed the lower bound by more than the tolerance, or returns the reason why
// not.
std::optional<Stop> bisect(Search& search);

}  // namespace meshgauge
