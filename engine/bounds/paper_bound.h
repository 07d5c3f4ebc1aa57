// The bound that a strategy of the paper gives a piece.
#pragma once

#include <memory>

#include "engine/reduction.h"
#include "engine/search.h"

namespace meshgauge {

// That of options.strategy, which is not `automatic`. It borrows `search`.
std::unique_ptr<PieceBound> make_paper_bound(const Options& options, Search& search);

}  // namespace meshgauge
