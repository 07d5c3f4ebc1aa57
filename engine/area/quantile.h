// Certified quantiles of the distance over A.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/area/totals.h"

namespace meshgauge {

// Returns an interval within `known`, a certified interval of it, that holds the smallest distance that the share p of
// the area is within. `parts` are all parts of A. Its ends are sought to `resolution`.
//
// Statement. Let S(t) be the share of the area beyond t. If S(t) <= 1 - p, the quantile is at most t; if S(t) > 1 - p,
// it is at least t. So each t with a certified bound of S(t) on one side of 1 - p gives an end.
AreaInterval quantile(double p, const TotalArea& area, const std::vector<WeightedEnclosure>& parts,
                      const AreaInterval& known, double resolution);

}  // namespace meshgauge
