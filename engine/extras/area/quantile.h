// Certified quantiles of the distance over A.
#pragma once

#include <deque>
#include <optional>

#include "engine/control.h"
#include "engine/extras/area/part.h"
#include "engine/extras/area/totals.h"

namespace meshgauge {

// All parts of A.
struct AllParts {
  const std::deque<WeightedEnclosure>& closed;
  const std::deque<Part>& open;
};

// Returns an interval within `known`, a certified interval of it, that holds the smallest distance that the share p of
// the area is within. Its ends are sought to `resolution`. nullopt: `stop` returned true.
//
// Statement. Let S(t) be the share of the area beyond t. If S(t) <= 1 - p, the quantile is at most t; if S(t) > 1 - p,
// it is at least t. So each t with a certified bound of S(t) on one side of 1 - p gives an end.
std::optional<AreaInterval> quantile(double p, const TotalArea& area, const AllParts& parts, const AreaInterval& known,
                                     double resolution, const Interrupted& stop);

}  // namespace meshgauge
