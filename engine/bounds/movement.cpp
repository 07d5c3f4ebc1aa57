#include "engine/bounds/movement.h"

namespace meshgauge {

bool same_indices(MeshView a, MeshView b, const Interrupted& interrupted) {
  if (a.triangles.size() != b.triangles.size()) return false;
  constexpr std::size_t kStep = std::size_t{1} << 16;  // triangles; about 0.1 ms
  for (std::size_t begin = 0; begin < a.triangles.size(); begin += kStep) {
    const std::size_t count = std::min(kStep, a.triangles.size() - begin);
    const auto of_a = a.triangles.subspan(begin, count), of_b = b.triangles.subspan(begin, count);
    if (!std::equal(of_a.begin(), of_a.end(), of_b.begin())) return false;
    if (interrupted()) return false;
  }
  return true;
}

Movement::Movement(MeshView a, MeshView b, const Frame& frame, const Interrupted& interrupted)
    : sq_(std::min(a.positions.size(), b.positions.size())) {
  complete_ = each_unless(interrupted, sq_.size(), [&](std::uint32_t v) {
    const Vec3 &p = a.positions[v], &q = b.positions[v];
    const Vec3 movement = frame.to_frame(q) - frame.to_frame(p);
    sq_[v] = movement.squaredNorm();
    mean_ += movement;
    none_ = none_ && p == q;
  });
  mean_ /= static_cast<double>(std::max<std::size_t>(sq_.size(), 1));
}

}  // namespace meshgauge
