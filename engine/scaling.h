// A mesh in another unit: every coordinate times a quotient of two whole numbers, and what rounding costs.
#pragma once

#include <optional>
#include <vector>

#include "engine/control.h"
#include "engine/mesh.h"

namespace meshgauge {

// A factor times / over, both whole and from 1 to kMost.
struct Factor {
  static constexpr double kMost = 0x1p20;

  double times = 1;
  double over = 1;

  bool is_one() const { return times == over; }
  bool operator==(const Factor&) const = default;
};

struct Scaled {
  std::vector<Vec3> positions;
  // Every position is within this of its exact image, so every point of the surface is, too (engine/rounding.h, R8).
  // In the new unit.
  double error = 0;
};

// Precondition: the mesh passes validate(). Linear time. nullopt: `interrupted` said to stop, or a coordinate that a
// triangle uses is beyond kMaxCoordinate in the new unit; of a vertex that no triangle uses nothing is promised.
std::optional<Scaled> scaled(MeshView mesh, const Factor& factor, const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
