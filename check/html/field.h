// Distances of points to a mesh.
#pragma once

#include <memory>

#include "engine/thread_pool.h"
#include "engine/tree/prepared.h"

namespace meshgauge::check {

// Computed, not certified, distances: for pictures and histograms, never for verdicts.
class DistanceField {
 public:
  // Borrows `mesh`. `box` contains the mesh and all points that will be asked for. Builds a tree, unless the mesh has
  // one for that frame. If `control` stops it, complete() is false and at() must not be called.
  DistanceField(const Prepared& mesh, const Box& box, ThreadPool& pool, Control& control);

  bool complete() const { return tree_ != nullptr; }

  double at(const Vec3& point) const;  // in the meshes' unit; thread safe

 private:
  Frame frame_;
  std::shared_ptr<Framed> framed_;
  const Bvh* tree_;
};

}  // namespace meshgauge::check
