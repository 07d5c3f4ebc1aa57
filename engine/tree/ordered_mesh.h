// A mesh in the unit frame, laid out so that neighbours in memory are neighbours in space: its triangles are in order
// along a space-filling curve.
#pragma once

#include <cstdint>
#include <span>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/frame.h"
#include "engine/mesh/large_array.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Returns the `chosen` triangles (empty: all) in the order of their centres along a Hilbert curve through `box`, the
// box of the mesh, with 1024 cells on each axis. Triangles in one cell are ordered the same way within their own box,
// and so on. Deterministic, also with several threads. Linear time. Empty: interrupted.
LargeArray<std::uint32_t> curve_order(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& box,
                                      Control& control, ThreadPool& pool);

struct OrderedMesh {
  Box box;                             // of the surface, in the frame
  LargeArray<Vec3> positions;          // the vertices that triangles use, in the order of first use
  LargeArray<Triangle> triangles;      // in the order of curve_order()
  LargeArray<std::uint32_t> original;  // by triangle: its index in the given mesh
  std::size_t given;                   // number of triangles of the given mesh

  // Orders the `chosen` triangles of `mesh`; empty: all. `original_box` is the box of the surface of `mesh`. O(n). If
  // `control` interrupts it, complete() is false and the mesh must not be used.
  OrderedMesh(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& original_box, const Frame& frame,
              Control& control, ThreadPool& pool);

  MeshView view() const { return {positions, triangles}; }
  bool complete() const { return !triangles.empty(); }
  std::size_t bytes() const { return sizeof *this + bytes_of(positions) + bytes_of(triangles) + bytes_of(original); }
};

}  // namespace meshgauge
