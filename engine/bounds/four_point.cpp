#include "engine/bounds/four_point.h"

namespace meshgauge {

Corner FourPoint::measure(const Vec3& p, const Piece&) {
  ++work_.nearest_queries;
  const Nearest found = nearest(target_, p, work_.triangle_tests);
  return {p, found.distance, found.slot};
}

double FourPoint::upper(const Piece& piece) {
  const auto& [c0, c1, c2] = piece.corners;
  const Vec3 centroid = (c0.point + c1.point + c2.point) / 3.0;
  const std::array candidates{c0.slot, c1.slot, c2.slot, measure(centroid, piece).slot};
  double best = std::numeric_limits<double>::infinity();
  for (auto it = candidates.begin(); it != candidates.end(); ++it) {
    if (std::find(candidates.begin(), it, *it) != it) continue;  // corners often share an owner
    work_.triangle_tests += 3;
    best = std::min(best, farthest_corner(piece, target_.prepared(*it), best));
  }
  return best;
}

}  // namespace meshgauge
