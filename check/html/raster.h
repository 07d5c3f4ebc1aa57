// A z-buffer: which triangle is visible at each pixel.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "check/html/camera.h"

namespace meshgauge::check {

// One sample for each pixel of the camera, at its centre; rows from the top.
struct Samples {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> triangle;  // visible triangle; kNone: none
  std::vector<float> depth;             // its depth (Seen::depth)

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

constexpr int kPointSize = 5;

// Draws everything farther from the viewer than `cut` (a Seen::depth; infinite: everything). Of two triangles at the
// same depth the first is visible. Corners are rounded to 64ths of a pixel and edges belong to both sides, so that
// neighbours leave no gap; a triangle without area on that grid is not drawn. A point of a cloud is a square of
// kPointSize samples. Time: linear in the triangles and the
// samples that they cover. Memory: the samples.
Samples rasterise(MeshView mesh, const Camera& camera, double cut = std::numeric_limits<double>::infinity());

}  // namespace meshgauge::check
