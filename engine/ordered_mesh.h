// A mesh as the engine works with it: in the unit frame, and laid out so that neighbours in memory are neighbours in
// space.
#pragma once

#include <cstdint>
#include <span>

#include "engine/control.h"
#include "engine/frame.h"
#include "engine/large_array.h"
#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge {

struct OrderedMesh {
  Box box;                             // the map to the frame is monotonic, so it takes the box along
  LargeArray<Vec3> positions;          // of the vertices that triangles use, in the order of their first use
  LargeArray<Triangle> triangles;      // along a space-filling curve (engine/curve.h)
  LargeArray<std::uint32_t> original;  // by triangle: its index in the caller's mesh
  std::size_t given;                   // triangles of the caller's mesh

  // Of the `chosen` triangles of `mesh`, or of all if none are. `original_box` holds the surface of `mesh`. O(n). When
  // `control` says to stop, what is made has no triangles and must not be used.
  OrderedMesh(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& original_box, const Frame& frame,
              Control& control, ThreadPool& pool);

  MeshView view() const { return {positions, triangles}; }
  bool complete() const { return !triangles.empty(); }
  std::size_t bytes() const { return sizeof *this + bytes_of(positions) + bytes_of(triangles) + bytes_of(original); }
};

}  // namespace meshgauge
