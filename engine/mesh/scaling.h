// Conversion of a mesh to another unit: every coordinate times a quotient of two whole numbers, with the rounding
// error.
#pragma once

#include <optional>
#include <vector>

#include "engine/control.h"
#include "engine/mesh.h"

namespace meshgauge {

// The factor times / over; both are whole numbers from 1 to kMost.
struct Factor {
  static constexpr double kMost = 0x1p20;

  double times = 1;
  double over = 1;

  bool is_one() const { return times == over; }
  bool operator==(const Factor&) const = default;
};

// The positions of a mesh after a map, rounded.
struct RoundedImage {
  std::vector<Vec3> positions;
  // The largest distance of a position from its exact image, in the image's unit. It holds for every point of the
  // surface, too (engine/rounding.h R8, R17).
  double error = 0;
};

// Returns the scaled positions. nullopt: interrupted, or a coordinate that a triangle uses is beyond kMaxCoordinate in
// the new unit. The position and the error of a vertex that no triangle uses are not specified. Precondition: the mesh
// passes validate(). Linear time.
std::optional<RoundedImage> scaled(MeshView mesh, const Factor& factor,
                                   const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
