// The data that the stages of a measurement share: the two meshes, their frame and the directions to measure.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/mesh/adjacency.h"
#include "engine/mesh/frame.h"
#include "engine/outcome.h"
#include "engine/rounding.h"
#include "engine/thread_pool.h"
#include "engine/tree/bvh.h"
#include "engine/tree/ordered_mesh.h"
#include "engine/tree/prepared.h"

namespace meshgauge {

// One of the two meshes. The pointers are null until the build stage sets them; `framed` owns what they point to.
struct MeasuredMesh {
  const Prepared& prepared;
  std::shared_ptr<Framed> framed = nullptr;
  const OrderedMesh* ordered = nullptr;
  const Bvh* tree = nullptr;

  MeshView given() const { return prepared.mesh(); }
};

// The triangles of a mesh that can be nearest to the rest of a direction, with a tree of their own.
class NearPart {
 public:
  // Precondition: `triangles` is not empty. If `control` interrupts it, complete() is false and it must not be used.
  NearPart(const MeasuredMesh& of, std::span<const std::uint32_t> triangles, const Frame& frame, Control& control,
           ThreadPool& pool)
      : mesh(of.given(), triangles, of.prepared.box(), frame, control, pool),
        tree(mesh.view(), of.framed->kernels(), control, pool) {}

  bool complete() const { return mesh.complete() && tree.complete(); }
  // nullptr: interrupted.
  const Adjacency* adjacency(ThreadPool& pool, const Interrupted& interrupted) {
    if (!adjacency_) adjacency_.emplace(mesh.view(), pool, interrupted);
    if (!adjacency_->complete()) adjacency_.reset();
    return adjacency_ ? &*adjacency_ : nullptr;
  }

  const OrderedMesh mesh;
  const Bvh tree;

 private:
  std::optional<Adjacency> adjacency_;
};

// One direction: distances from the points of `from` to `to`.
struct MeasuredDirection {
  Directed& result;
  MeasuredMesh& from;
  MeasuredMesh& to;
  bool settled = false;                         // the build stage has found the result
  std::unique_ptr<OrderedMesh> rest = nullptr;  // null: search all of `from`; else only these of its triangles
  // Triangle of `rest` whose corners give most of the lower bound that the others were left out for; nullopt: none
  // were.
  std::optional<std::uint32_t> first = std::nullopt;
  double left_out = 0;                       // computed upper bound of the triangles that are not in `rest`
  std::unique_ptr<NearPart> near = nullptr;  // null: search all of `to`; else this is enough for `rest`
  double reach = std::numeric_limits<double>::infinity();  // each triangle not in `near` is farther from all of `rest`
  // By triangle of the given `from`: an upper bound of its distance that the search has met, slack included, frame
  // units; infinite: none. Empty: not asked for, or not searched.
  LargeArray<float> bounds{};
};

// The largest difference between the meshes at hand and the meshes that they stand for: the sum of both
// Prepared::error(), rounded up, in the meshes' unit. 0: none.
class InputError {
 public:
  InputError(const Prepared& a, const Prepared& b)
      : error_(a.error() > 0 || b.error() > 0 ? rounding::add_up(a.error(), b.error()) : 0) {}

  double value() const { return error_; }

  // The certified interval of the meshes that are stood for, from that of the meshes at hand. An error of 0 changes no
  // bit.
  Bounds widened(Bounds bounds) const {
    if (error_ == 0) return bounds;
    bounds.lower = rounding::subtract_down(bounds.lower, error_);
    bounds.upper = rounding::add_up(bounds.upper, error_);
    return bounds;
  }

  // Upper bound of what widened() adds to the width of an interval, in frame units. It includes the roundings of
  // widened() itself: those of two sums of at most 4.
  double cost(const Frame& frame) const {
    return error_ == 0 ? 0 : 2 * frame.length_to_frame(error_) + 16 * rounding::kUnit;
  }

 private:
  double error_;
};

// `directions` refer to `a` and `b`: not copyable.
struct MeasuredPair {
  MeasuredPair(const Prepared& prepared_a, const Prepared& prepared_b)
      : a{prepared_a}, b{prepared_b}, error(prepared_a, prepared_b) {}
  MeasuredPair(const MeasuredPair&) = delete;
  MeasuredPair& operator=(const MeasuredPair&) = delete;

  MeasuredMesh a;
  MeasuredMesh b;
  InputError error;
  Frame frame;
  std::vector<MeasuredDirection> directions;
};

}  // namespace meshgauge
