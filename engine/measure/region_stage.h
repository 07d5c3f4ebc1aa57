// The measurement of parts of the surfaces, instead of a search over the whole.
//
// The distance within a region R is the maximum of sup over A in R of d(x, B) and sup over B in R of d(y, A), of the
// directions asked for: each point is measured to all of the other mesh. A group is a part of B, so its distance is
// that from B alone, and no point of A lies in it. Regions may overlap; each is measured by itself. The rest is the
// closure of what lies in no region. Both surfaces are covered, so the distance of the whole lies between the maxima of
// the lower and of the upper bounds.
#pragma once

#include "engine/control.h"
#include "engine/options.h"
#include "engine/outcome.h"
#include "engine/search/measured_pair.h"

namespace meshgauge {

// Measures each region of `options`, and the rest, to its own limit or the rules of the tolerance, whose share of the
// diagonal is that of the whole. Fills in outcome.regions, and with it the bounds, counters and times of the whole.
// Preconditions: outcome.diagonal_a is known, and each direction of `pair` has its interval before any work.
void measure_regions(MeasuredPair& pair, const Options& options, Control& control, Outcome& outcome);

}  // namespace meshgauge
