// Which triangle is seen where: a z-buffer.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "check/html/camera.h"

namespace meshgauge::check {

// One sample a pixel of the camera, in its middle; rows from above.
struct Samples {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> triangle;  // the one nearest to the viewer; kNone: nothing is there
  std::vector<float> depth;             // of it, as Seen::depth

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

// Nothing that is nearer to the viewer than `cut` (a Seen::depth) is drawn: infinite for all. Of two triangles at the
// same depth the first is seen. Corners are moved to the nearest 64th of a pixel and edges belong to both sides, so
// that there is no gap between neighbours; a triangle without an area there is not seen. Linear in the triangles and in
// the samples that they cover; memory for the samples alone.
Samples rasterise(MeshView mesh, const Camera& camera, double cut = std::numeric_limits<double>::infinity());

}  // namespace meshgauge::check
