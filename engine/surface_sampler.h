// Points that lie evenly on a mesh: stratified, so that few of them tell much.
#pragma once

#include <cstddef>
#include <random>

#include "engine/control.h"
#include "engine/large_array.h"
#include "engine/mesh.h"
#include "engine/statistics.h"

namespace meshgauge {

// The surface as one line: its triangles in a row, each along a curve that fills it, and every stretch of the line as
// long as the area that it covers. Cut into equal strata, which are compact patches of the surface when the triangles
// come along a space-filling curve (OrderedMesh). A point that is uniform in a stratum chosen uniformly is uniform on
// the surface.
//
// Degenerate triangles have no area and are never hit; without any area the line is that of their longest edges, or
// gives every triangle, all of them points, the same length.
class SurfaceSampler {
 public:
  // `mesh` has a triangle, lies in the unit frame and must outlive the sampler. Linear time; must not be used when
  // `control` said to stop.
  SurfaceSampler(MeshView mesh, std::size_t strata, Control& control);

  Weight weight() const { return weight_; }
  std::size_t strata() const { return strata_; }

  // Uniform in the stratum, up to rounding. Thread safe.
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
