// A bound for two meshes with the same triangle indices: a mesh and a copy of it that was moved, smoothed or deformed.
// It needs neither an order nor a tree.
//
// Statement. Let P be a triangle of A with the corners a_i, and T the triangle of B of the same number, with the
// corners b_i. Then h(P,B) <= max |a_i - b_i|.
// Proof. A point of P is a convex combination sum w_i a_i. The point sum w_i b_i lies in T, and their distance
// |sum w_i (a_i - b_i)| is at most max |a_i - b_i|, since norms are convex.
//
// Rounding. The corners are those of the frame. By rounding.h R1 a computed length errs by less than 13u, for which
// kDistanceSlack has room.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/frame.h"
#include "engine/mesh/large_array.h"
#include "engine/mesh/mesh_index.h"

namespace meshgauge {

// Whether both meshes have the same triangles by index. False also when interrupted.
bool same_indices(MeshView a, MeshView b, const Interrupted& interrupted);

// The movements of the vertices from A to B. Precondition: same_indices(a, b).
class Movement {
 public:
  // Linear time. If it is interrupted, complete() is false and it must not be used.
  Movement(MeshView a, MeshView b, const Frame& frame, const Interrupted& interrupted);

  bool complete() const { return complete_; }
  // Whether no vertex moves: the same positions in the meshes' own coordinates, exactly.
  bool none() const { return none_; }
  // The movement of all vertices on average. Not finite if an unused vertex is not.
  const Vec3& mean() const { return mean_; }

  // The square of the largest movement of a corner of this triangle of A. Its root is the bound.
  double upper_sq(const Triangle& triangle) const {
    return std::max(std::max(sq_[triangle[0]], sq_[triangle[1]]), sq_[triangle[2]]);
  }
  // The corner of the triangle that moves farthest.
  std::uint32_t farthest_corner(const Triangle& triangle) const {
    return *std::max_element(triangle.begin(), triangle.end(),
                             [this](std::uint32_t v, std::uint32_t w) { return sq_[v] < sq_[w]; });
  }
  // How far a vertex moves.
  double of(std::uint32_t vertex) const { return std::sqrt(sq_[vertex]); }

 private:
  LargeArray<double> sq_;  // by vertex
  Vec3 mean_ = Vec3::Zero();
  bool none_ = true;
  bool complete_ = false;
};

}  // namespace meshgauge
