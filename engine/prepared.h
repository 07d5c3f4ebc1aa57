// A mesh with all that measuring makes of it, so that a mesh that is measured again and again is prepared once.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "engine/adjacency.h"
#include "engine/bvh.h"
#include "engine/control.h"
#include "engine/frame.h"
#include "engine/kernels/kernels.h"
#include "engine/lazy.h"
#include "engine/mesh.h"
#include "engine/mesh_index.h"
#include "engine/options.h"
#include "engine/ordered_mesh.h"
#include "engine/outcome.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// A mesh in one frame, and what is made of it there. Each part is made by the first who needs it and is the same
// whoever makes it, on however many threads. Null: `control` (or `interrupted`) said to stop. Thread safe.
class Framed {
 public:
  Framed(MeshView given, const Box& box, const Frame& frame, const Kernels& kernels)
      : given_(given), box_(box), frame_(frame), kernels_(kernels) {}

  const Frame& frame() const { return frame_; }
  const Kernels& kernels() const { return kernels_; }

  const OrderedMesh* order(Control& control, ThreadPool& pool);
  const Bvh* tree(Control& control, ThreadPool& pool);
  // Precondition: order() has given one.
  const Adjacency* adjacency(ThreadPool& pool, const Interrupted& interrupted);

  std::size_t bytes() const;  // of what is made

 private:
  const MeshView given_;
  const Box box_;
  const Frame frame_;
  const Kernels& kernels_;
  Lazy<OrderedMesh> order_;
  Lazy<Bvh> tree_;
  Lazy<Adjacency> adjacency_;
};

// Immutable, as far as can be seen but for the time a measurement takes: everything is made when it is first needed,
// and kept. Any number of measurements may use it at once; one that is interrupted leaves nothing half made.
//
// Orders, trees and adjacencies are those of a frame (engine/frame.h), which depends on both meshes. Frames are coarse
// so that nearly equal partners lead to the same one; those of the last kFrames are kept.
class Prepared {
 public:
  static constexpr std::size_t kFrames = 2;

  // `once`: what pays only from the second measurement on is not made.
  enum class Use { once, often };

  // `mesh` passes validate(); it is kept alive by `arrays`, or by the caller. `box`: bounding_box() of it, if that is
  // known already. `error`: as error().
  explicit Prepared(MeshView mesh, Use use = Use::once, std::shared_ptr<const void> arrays = nullptr,
                    const std::optional<Box>& box = std::nullopt, double error = 0)
      : mesh_(mesh), use_(use), arrays_(std::move(arrays)), error_(error) {
    if (box) std::call_once(box_made_, [&] { box_ = *box; });
  }

  MeshView mesh() const { return mesh_; }
  Use use() const { return use_; }
  // The mesh that is meant and this one are within this of each other (engine/scaling.h), in the mesh's unit: what is
  // certified holds for the mesh that is meant. 0: it is this one.
  double error() const { return error_; }
  const Box& box() const;     // as bounding_box()
  std::size_t bytes() const;  // of the mesh and of all that is kept with it now

  // For measure(). The parts of this mesh in that frame. Whoever holds them may use them as long as the mesh lives,
  // also when they are no longer kept here.
  std::shared_ptr<Framed> in(const Frame& frame, const Kernels& kernels) const;
  // Null: interrupted.
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
  mutable std::mutex mutex_;                                     // guards what follows
  mutable std::array<std::shared_ptr<Framed>, kFrames> frames_;  // the last one used first; null: none yet
};

// As measure() of two meshes, with the same bits on one thread, whatever was made of them before.
Outcome measure(const Prepared& a, const Prepared& b, const Options& options, Control& control);

}  // namespace meshgauge
