// Regions of space: which part of a surface is measured by itself (docs/design.md, section 12).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>

#include "engine/mesh.h"

namespace meshgauge {

// A closed ball.
struct Sphere {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

// A closed region. Coordinates and lengths are in the meshes' unit, of at most kMaxCoordinate in magnitude.
// Preconditions: low <= high on each axis of a box; radius >= 0.
struct Region {
  static constexpr std::size_t kMost = 64;  // of one measurement

  std::variant<Box, Sphere> shape;
  std::optional<double> max_distance;  // nullopt: Options::max_distance
  std::string name = {};               // for the caller
};

}  // namespace meshgauge
