// Which triangles of a mesh share an edge. Corners at the same position count as one vertex, so that unwelded meshes
// have neighbours too; any number of triangles may meet in an edge.
#pragma once

#include <array>
#include <cstdint>

#include "engine/control.h"
#include "engine/large_array.h"
#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge {

class Adjacency {
 public:
  // Triangle t's edge i joins its corners i and i+1 (mod 3).
  struct Edge {
    std::uint32_t triangle;
    std::uint32_t edge;
  };

  // All positions of `mesh` must be finite. Linear time, 0.05 us a triangle; the same whatever the pool. When
  // `interrupted`, asked on any thread, says so it stops: then complete() is false, and this must not be used.
  Adjacency(MeshView mesh, ThreadPool& pool, const Interrupted& interrupted = never_interrupted);
  bool complete() const { return complete_; }
  std::size_t bytes() const { return sizeof *this + bytes_of(next_); }

  // The next triangle around that edge, in a ring: follow it until it comes back. Itself if there is no other.
  Edge next_around(std::uint32_t triangle, std::uint32_t edge) const {
    const std::uint32_t half_edge = next_[3 * std::size_t{triangle} + edge];
    return {half_edge / 3, half_edge % 3};
  }

 private:
  LargeArray<std::uint32_t> next_;  // by half-edge 3*triangle + edge
  bool complete_ = false;
};

}  // namespace meshgauge
