#include "engine/mesh/scaling.h"

#include <algorithm>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBetweenLooks = std::size_t{1} << 17;

}  // namespace

std::optional<RoundedImage> scaled(MeshView mesh, const Factor& factor, const Interrupted& interrupted) {
  RoundedImage result;
  result.positions.resize(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    if (i % kBetweenLooks == 0 && interrupted()) return std::nullopt;
    result.positions[i] = mesh.positions[i] * factor.times / factor.over;
  }
  double largest = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % kBetweenLooks == 0 && interrupted()) return std::nullopt;
    for (const std::uint32_t v : mesh.triangles[t]) {
      const double size = result.positions[v].cwiseAbs().maxCoeff();
      if (!(size <= kMaxCoordinate)) return std::nullopt;
      largest = std::max(largest, size);
    }
  }
  result.error = rounding::scaling_error(largest);
  return result;
}

}  // namespace meshgauge
