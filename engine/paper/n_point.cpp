#include "engine/paper/n_point.h"

namespace meshgauge {
namespace {

constexpr std::array<int, 6> kStencils{4, 10, 31, 109, 409, 1585};

// The barycentric coordinates of the point (i,j)/m of the triangle.
Vec3 weights_at(double i, double j, double m) { return {1 - (i + j) / m, i / m, j / m}; }

std::vector<Vec3> stencil(int level) {
  const int m = 1 << level;
  std::vector<Vec3> weights;
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i + j <= m; ++i) {
      const bool corner = (i == 0 && j == 0) || i == m || j == m;
      if (!corner) weights.push_back(weights_at(i, j, m));
      if (i + j < m) weights.push_back(weights_at(i + 1.0 / 3, j + 1.0 / 3, m));      // centroid, upright
      if (i + j < m - 1) weights.push_back(weights_at(i + 2.0 / 3, j + 2.0 / 3, m));  // centroid, inverted
    }
  }
  return weights;
}

}  // namespace

std::optional<int> stencil_level(int points) {
  const auto it = std::find(kStencils.begin(), kStencils.end(), points);
  if (it == kStencils.end()) return std::nullopt;
  return static_cast<int>(it - kStencils.begin());
}

NPoint::NPoint(const Bvh& target, int level, Work& work, const Interrupted* stop)
    : target_(target), weights_(stencil(level)), work_(work), stop_(stop), polling_(stop, work.triangle_tests) {}

Corner NPoint::measure(const Vec3& p, const Piece&) { return nearest_corner(target_, p, work_, stop_); }

double NPoint::upper(const Piece& piece) {
  const auto& [a, b, c] = piece.corners;
  owners_ = {a.slot, b.slot, c.slot};
  for (const Vec3& w : weights_) {
    if (polling_.stopped() || polling_.poll(work_.triangle_tests)) break;
    owners_.push_back(measure(w[0] * a.point + w[1] * b.point + w[2] * c.point, piece).slot);
  }
  std::sort(owners_.begin(), owners_.end());
  owners_.erase(std::unique(owners_.begin(), owners_.end()), owners_.end());
  return least_farthest(piece, target_, owners_, work_);
}

}  // namespace meshgauge
