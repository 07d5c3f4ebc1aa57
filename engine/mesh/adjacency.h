// The triangles of a mesh that share an edge. Corners at the same position count as one vertex, so that unwelded meshes
// have neighbours too. Any number of triangles may meet in an edge.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/large_array.h"
#include "engine/thread_pool.h"

namespace meshgauge {

class Adjacency {
 public:
  // An edge of a triangle: edge i joins the corners i and i+1 (mod 3).
  struct Edge {
    std::uint32_t triangle;
    std::uint32_t edge;
  };

  // Precondition: all positions of `mesh` are finite. Linear time, about 0.05 us for each triangle; the result does not
  // depend on the pool. `interrupted` is polled on any of its threads; if it returns true, complete() is false and the
  // adjacency must not be used.
  Adjacency(MeshView mesh, ThreadPool& pool, const Interrupted& interrupted = never_interrupted);
  bool complete() const { return complete_; }
  std::size_t bytes() const { return sizeof *this + bytes_of(next_); }

  // Returns the next triangle around that edge. The triangles of an edge form a ring, which leads back to the first; a
  // triangle without a neighbour is its own successor.
  Edge next_around(std::uint32_t triangle, std::uint32_t edge) const {
    const std::uint32_t half_edge = next_[3 * std::size_t{triangle} + edge];
    return {half_edge / 3, half_edge % 3};
  }
  // Returns the other triangle of an edge that exactly two triangles share; nullopt: one, or more than two do.
  std::optional<Edge> only_partner(std::uint32_t triangle, std::uint32_t edge) const {
    const std::uint32_t own = 3 * triangle + edge, other = next_[own];
    if (other == own || next_[other] != own) return std::nullopt;
    return Edge{other / 3, other % 3};
  }

 private:
  LargeArray<std::uint32_t> next_;  // by half-edge 3*triangle + edge
  bool complete_ = false;
};

}  // namespace meshgauge
