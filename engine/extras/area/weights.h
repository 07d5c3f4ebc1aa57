// The areas of A's triangles, as weights with an error.
#pragma once

#include "engine/tree/ordered_mesh.h"

namespace meshgauge {

// Weights are in a unit of their own, about the square of the mesh's width. The area of a triangle lies between its
// weight and its weight + error: rounding.h R13.
class AreaWeights {
 public:
  struct Weight {
    double weight = 0;
    double error = 0;
  };

  // `error`: as in PartBounder.
  AreaWeights(const OrderedMesh& mesh, double error);

  Weight of(std::size_t triangle) const;

 private:
  MeshView mesh_;
  double scale_;  // a power of two
  double moved_;  // how far an edge's end may be moved, in scaled units
};

}  // namespace meshgauge
