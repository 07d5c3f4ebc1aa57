#include "engine/bounds/four_point.h"

namespace meshgauge {

Corner FourPoint::measure(const Vec3& p, const Piece&) { return nearest_corner(target_, p, work_, stop_); }

double FourPoint::upper(const Piece& piece) {
  const auto& [a, b, c] = piece.corners;
  std::array owners{a.slot, b.slot, c.slot, measure((a.point + b.point + c.point) / 3.0, piece).slot};
  std::sort(owners.begin(), owners.end());
  const auto end = std::unique(owners.begin(), owners.end());  // corners often share an owner
  return least_farthest(piece, target_, std::span(owners.begin(), end), work_);
}

}  // namespace meshgauge
