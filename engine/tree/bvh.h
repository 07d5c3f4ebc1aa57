// A tree of axis-aligned boxes over the triangles of one mesh, in the unit frame.
//
// Flat and wide: nodes of eight children in one array, leaves of eight prepared triangles in another
// (engine/kernels/layout.h). Each leaf holds eight consecutive triangles, and the nodes above are split by the surface
// area heuristic. The mesh should be an OrderedMesh; for any other the tree is valid but slow.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/kernels/kernels.h"
#include "engine/mesh.h"
#include "engine/mesh/large_array.h"
#include "engine/thread_pool.h"
#include "engine/tree/triangle.h"

namespace meshgauge {

class Bvh {
 public:
  static constexpr std::uint32_t kRoot = 0;

  // Builds a tree over `mesh`, which must have a triangle and outlive the tree. If `control` interrupts it, complete()
  // is false and the tree must not be used. The tree does not depend on the pool and the kernels. O(n log n).
  Bvh(MeshView mesh, const Kernels& kernels, Control& control, ThreadPool& pool);

  MeshView mesh() const { return mesh_; }
  bool complete() const { return !nodes_.empty(); }
  std::size_t bytes() const { return sizeof *this + bytes_of(nodes_) + bytes_of(blocks_); }
  const Kernels& kernels() const { return *kernels_; }
  TreeView view() const { return {nodes_.data(), blocks_.data()}; }

  const LargeArray<WideNode>& nodes() const { return nodes_; }
  // Returns a box that holds all triangles below the child. Precondition: node.child[lane] is not kNone.
  static Box child_box(const WideNode& node, std::size_t lane);

  // The prepared triangle: lane t % 8 of block t / 8 for triangle t.
  PreparedTriangle prepared(std::uint32_t triangle) const;
  // The largest computed distance of `points` from the triangle: rounding.h R3. Layout of `points`: see
  // Kernels::farthest_sq.
  double farthest(const PointBlock& points, std::uint32_t triangle) const {
    return std::sqrt(kernels_->farthest_sq(blocks_[triangle / kLanes], triangle % kLanes, points));
  }
  // The triangles of a block are [block_begin, block_end).
  static std::uint32_t block_begin(std::uint32_t block) { return block * static_cast<std::uint32_t>(kLanes); }
  std::uint32_t block_end(std::uint32_t block) const {
    return std::min(block_begin(block) + static_cast<std::uint32_t>(kLanes),
                    static_cast<std::uint32_t>(mesh_.triangles.size()));
  }

  // The largest residual of the prepared triangles (rounding.h R2).
  double residual() const { return residual_; }

 private:
  std::vector<Box> prepare_blocks(Control& control, ThreadPool& pool);
  bool fit_boxes(std::span<const Box> block_boxes, Control& control, ThreadPool& pool);

  MeshView mesh_;
  const Kernels* kernels_;
  LargeArray<WideNode> nodes_;
  LargeArray<TriangleBlock> blocks_;
  double residual_ = 0;
};

}  // namespace meshgauge
