// The front of meshes that are far from each other: single points of B bound triangles of A.
//
// Statement. Let b be a point of B and P a triangle of A. Then h(P,B) <= max over corners c of P of |c - b|.
// Proof. |. - b| is convex, so its maximum over P is at a corner; and d(x,B) <= |x - b|.
//
// Rounding. b is a computed nearest point, within 38u + residual of B (rounding.h R2), and the length errs by 13u (R1):
// kDistanceSlack has room for all but the residual of b's triangle, which is added.
//
// Where h(A,B) is large against the meshes' detail, the nearest points of a few vertices bound most triangles. The
// vertices are the farthest ones from B: first from its box, then from the points that were found.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/fast/front_work.h"
#include "engine/mesh/large_array.h"

namespace meshgauge {

class PointFront : private FrontWork {
 public:
  using FrontWork::FrontWork;
  using FrontWork::lower;

  FrontEnd run();

 private:
  // A vertex of A.
  struct Vertex {
    double least_sq;      // the squared distance from the nearest of points_; before the first one, from B's box
    std::uint32_t marks;  // bit k: points_[k] is within the limit
  };

  std::vector<Vec3> sample(MeshView mesh, std::size_t count) const;
  bool seems_far() const;
  bool start();
  std::vector<Query> farthest_vertices() const;
  static void bound_queries(std::vector<Query>& queries, const std::vector<Vec3>& corners);
  bool mark(std::size_t first);
  double upper_sq(const Triangle& triangle) const;

  std::vector<Vec3> points_;  // of B
  LargeArray<Vertex> vertices_;
  std::vector<std::uint32_t> any_;  // by vertex of A: a triangle that uses it, or kNone
  double off_ = 0;                  // the largest distance of points_ from B that kDistanceSlack has no room for
  std::size_t unmarked_ = 0;        // used vertices without a mark
  double marked_sq_ = 0;            // the largest squared distance that has a mark
};

}  // namespace meshgauge
