// A tree of axis-aligned boxes over the triangles of one mesh, in the unit frame.
//
// Flat: nodes in one array, children side by side; triangles prepared and stored in leaf order. The boxes are exact:
// minima and maxima of stored coordinates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/triangle.h"

namespace meshgauge {

class Bvh {
 public:
  struct Node {
    Box box;
    std::uint32_t first = 0;  // leaf: first slot; inner: left child, the right one follows it
    std::uint32_t count = 0;  // leaf: number of slots; inner: 0
    bool is_leaf() const { return count != 0; }
  };

  static constexpr std::uint32_t kRoot = 0;
  static constexpr std::size_t kMaxDepth = 80;  // no path is longer: room for the stacks of queries

  // Builds over `mesh`, which must outlive the tree and have a triangle. Stops when `control` says so:
  // then interruption() tells why and the tree must not be used. Deterministic. O(n log n).
  Bvh(MeshView mesh, Control& control);

  MeshView mesh() const { return mesh_; }
  Interruption interruption() const { return interruption_; }
  const std::vector<Node>& nodes() const { return nodes_; }

  // Slots are triangles in leaf order.
  const PreparedTriangle& prepared(std::uint32_t slot) const { return prepared_[slot]; }
  std::uint32_t triangle(std::uint32_t slot) const { return order_[slot]; }

  // Largest residual of the prepared triangles (rounding.h, R2).
  double residual() const { return residual_; }

 private:
  void split(Control& control);
  void prepare_all(Control& control);
  void fit_boxes();

  MeshView mesh_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<PreparedTriangle> prepared_;
  double residual_ = 0;
  Interruption interruption_ = Interruption::none;
};

// Squared distance from p to the box, 0 inside; rounded (rounding.h, R6).
inline double distance_sq(const Box& box, const Vec3& p) {
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(Vec3::Zero()).squaredNorm();
}

}  // namespace meshgauge
