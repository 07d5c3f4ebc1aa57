// Draws points uniformly on a mesh, stratified so that fewer points give the same precision.
#pragma once

#include <cstddef>
#include <random>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/large_array.h"
#include "engine/statistics.h"

namespace meshgauge {

// Maps the surface to a line: its triangles in a row, each along a curve that fills it, so that every stretch of the
// line is as long as the area that it covers. The line is cut into equal strata, which are compact patches of the
// surface if the triangles are in the order of a space-filling curve (OrderedMesh). A uniform point in a uniformly
// chosen stratum is uniform on the surface.
//
// Degenerate triangles have no area and are never hit. If no triangle has area, the line consists of their longest
// edges; if those have no length either, of the same length for each triangle.
class SurfaceSampler {
 public:
  // `mesh` has a triangle, lies in the unit frame and must outlive the sampler. Linear time. If `control` interrupts
  // it, it must not be used.
  SurfaceSampler(MeshView mesh, std::size_t strata, Control& control);

  Weight weight() const { return weight_; }
  std::size_t strata() const { return strata_; }

  // Returns a point that is uniform in the stratum, up to rounding. Thread safe.
  Vec3 point(std::size_t stratum, std::mt19937_64& random) const;

 private:
  template <class Length>
  bool measure(Control& control, const Length& length);

  MeshView mesh_;
  std::size_t strata_;
  Weight weight_ = Weight::points;
  LargeArray<double> ends_;  // by triangle: where it ends on the line
};

}  // namespace meshgauge
