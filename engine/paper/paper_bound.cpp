#include "engine/paper/paper_bound.h"

#include "engine/paper/four_point.h"
#include "engine/paper/n_point.h"
#include "engine/paper/triangle_set.h"

namespace meshgauge {

std::unique_ptr<PieceBound> make_paper_bound(const Options& options, Search& search) {
  switch (options.strategy) {
    case Strategy::n_point:
      return std::make_unique<NPoint>(search.to(), stencil_level(options.points).value_or(0), search.work(),
                                      search.stop());
    case Strategy::triangle_set:
      return std::make_unique<TriangleSet>(search);
    case Strategy::four_point:
    case Strategy::automatic:
      break;
  }
  return std::make_unique<FourPoint>(search.to(), search.work(), search.stop());
}

}  // namespace meshgauge
