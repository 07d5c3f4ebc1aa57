#include "engine/bounds/tightness.h"

#include <numeric>
#include <vector>

#include "engine/rounding.h"

namespace meshgauge {

double best_upper(const Piece& piece, const Bvh& target) {
  // By the very function that the strategies use, so that the same triangle has the same computed value.
  std::vector<std::uint32_t> all(target.mesh().triangles.size());
  std::iota(all.begin(), all.end(), 0U);
  Work uncounted;
  return least_farthest(piece, target, all, uncounted);
}

double tightness(double best, double upper, const Bvh& target) {
  if (upper <= rounding::kDistanceSlack + target.residual()) return 1;
  return best / upper;
}

}  // namespace meshgauge
