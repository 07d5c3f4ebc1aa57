#include "engine/fast/bounds/movement.h"

#include <cstring>

namespace meshgauge {

bool same_indices(MeshView a, MeshView b, const Interrupted& interrupted) {
  if (a.triangles.size() != b.triangles.size()) return false;
  constexpr std::size_t kStep = std::size_t{1} << 16;  // triangles; about 0.1 ms
  for (std::size_t begin = 0; begin < a.triangles.size(); begin += kStep) {
    const std::size_t count = std::min(kStep, a.triangles.size() - begin);
    if (std::memcmp(&a.triangles[begin], &b.triangles[begin], count * sizeof(Triangle)) != 0) return false;
    if (interrupted()) return false;
  }
  return true;
}

Movement::Movement(MeshView a, MeshView b, const Frame& frame, const Interrupted& interrupted)
    : sq_(std::min(a.positions.size(), b.positions.size())) {
  double* const sq = sq_.data();  // locals: a store there might change a member
  Vec3 sum = Vec3::Zero();
  bool none = true;
  complete_ = each_unless(interrupted, sq_.size(), [&, frame](std::uint32_t v) {
    const Vec3 &p = a.positions[v], &q = b.positions[v];
    const Vec3 movement = frame.to_frame(q) - frame.to_frame(p);
    sq[v] = movement.squaredNorm();
    sum += movement;
    none = none && p == q;
  });
  none_ = none;
  mean_ = sum / static_cast<double>(std::max<std::size_t>(sq_.size(), 1));
}

}  // namespace meshgauge
