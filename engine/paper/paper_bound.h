// Makes the bound of one of the paper's strategies.
#pragma once

#include <memory>

#include "engine/paper/reduction.h"
#include "engine/search/search.h"

namespace meshgauge {

// Returns the bound of options.strategy. It borrows `search`. Precondition: the strategy is not `automatic`.
std::unique_ptr<PieceBound> make_paper_bound(const Options& options, Search& search);

}  // namespace meshgauge
