// A mesh with the structures that measuring builds from it: repeated measurements of the mesh build them once.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "engine/control.h"
#include "engine/kernels/kernels.h"
#include "engine/mesh.h"
#include "engine/mesh/adjacency.h"
#include "engine/mesh/frame.h"
#include "engine/mesh/mesh_index.h"
#include "engine/options.h"
#include "engine/outcome.h"
#include "engine/thread_pool.h"
#include "engine/tree/bvh.h"
#include "engine/tree/lazy.h"
#include "engine/tree/ordered_mesh.h"

namespace meshgauge {

// One mesh in one frame: its order, tree and adjacency. The first call that needs a structure builds it while other
// calls for it wait; the result is the same on any number of threads. nullptr: interrupted. Thread safe.
class Framed {
 public:
  Framed(MeshView given, const Box& box, const Frame& frame, const Kernels& kernels)
      : given_(given), box_(box), frame_(frame), kernels_(kernels) {}

  const Frame& frame() const { return frame_; }
  const Kernels& kernels() const { return kernels_; }

  const OrderedMesh* order(Control& control, ThreadPool& pool);
  const Bvh* tree(Control& control, ThreadPool& pool);
  // Precondition: order() has returned a mesh.
  const Adjacency* adjacency(ThreadPool& pool, const Interrupted& interrupted);

  std::size_t bytes() const;  // of the structures built so far

 private:
  const MeshView given_;
  const Box box_;
  const Frame frame_;
  const Kernels& kernels_;
  Lazy<OrderedMesh> order_;
  Lazy<Bvh> tree_;
  Lazy<Adjacency> adjacency_;
};

// Builds every structure on first use and keeps it; to callers it is immutable. Thread safe: any number of measurements
// may use it at the same time, and an interrupted one leaves no incomplete structure.
//
// Orders, trees and adjacencies belong to a frame (engine/mesh/frame.h), which depends on both meshes. Frames are
// coarse so that nearly equal partners lead to the same one. The kFrames used last are kept.
class Prepared {
 public:
  static constexpr std::size_t kFrames = 2;

  // `once` skips structures that pay only from the second measurement on.
  enum class Use { once, often };

  // Precondition: `mesh` passes validate(). `arrays` keeps its memory alive; null: the caller does. `box`:
  // bounding_box(mesh), if it is known already. `error`: see error().
  explicit Prepared(MeshView mesh, Use use = Use::once, std::shared_ptr<const void> arrays = nullptr,
                    const std::optional<Box>& box = std::nullopt, double error = 0)
      : mesh_(mesh), use_(use), arrays_(std::move(arrays)), error_(error) {
    if (box) std::call_once(box_made_, [&] { box_ = *box; });
  }

  MeshView mesh() const { return mesh_; }
  Use use() const { return use_; }
  // How far the surface may be from the exact one that it stands for, in the mesh's unit: above 0 when rounding has
  // moved its vertices (engine/mesh/scaling.h). measure() certifies bounds for the exact surface.
  double error() const { return error_; }
  const Box& box() const;     // bounding_box(mesh())
  std::size_t bytes() const;  // of the mesh and of the structures kept with it now

  // For measure(): this mesh in `frame`. The result is valid as long as the mesh's arrays, even when it is no longer
  // kept here.
  std::shared_ptr<Framed> in(const Frame& frame, const Kernels& kernels) const;
  // Indexes over the mesh's own coordinates. nullptr: interrupted.
  const PositionIndex* positions(const Interrupted& interrupted) const;
  const TriangleIndex* triangles(const Interrupted& interrupted) const;

 private:
  const MeshView mesh_;
  const Use use_;
  const std::shared_ptr<const void> arrays_;
  const double error_;
  mutable std::once_flag box_made_;
  mutable Box box_;
  mutable Lazy<PositionIndex> positions_;
  mutable Lazy<TriangleIndex> triangles_;
  mutable std::mutex mutex_;                                     // guards frames_
  mutable std::array<std::shared_ptr<Framed>, kFrames> frames_;  // the last used first; null: none yet
};

// As measure() of engine/hausdorff.h. On one thread the bits do not depend on what was built before.
Outcome measure(const Prepared& a, const Prepared& b, const Options& options, Control& control);

}  // namespace meshgauge
