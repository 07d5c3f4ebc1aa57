#include "engine/paper/four_point.h"

namespace meshgauge {

Corner FourPoint::measure(const Vec3& p, const Piece&) {
  if (const auto it = shared_.find(p); it != shared_.end()) {
    const Corner corner{p, it->second.distance, it->second.slot};
    shared_.erase(it);
    ++work_.cache_hits;
    return corner;
  }
  const Corner corner = nearest_corner(target_, p, work_, stop_);
  if (corner.complete) shared_.emplace(p, Found{corner.distance, corner.slot});
  return corner;
}

double FourPoint::upper(const Piece& piece) {
  const auto& [a, b, c] = piece.corners;
  std::array owners{a.slot, b.slot, c.slot,
                    nearest_corner(target_, (a.point + b.point + c.point) / 3.0, work_, stop_).slot};
  std::sort(owners.begin(), owners.end());
  const auto end = std::unique(owners.begin(), owners.end());  // corners often share an owner
  return least_farthest(piece, target_, std::span(owners.begin(), end), work_);
}

}  // namespace meshgauge
