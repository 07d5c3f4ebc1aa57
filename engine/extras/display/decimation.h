// Reduces a mesh to fewer triangles, for display only: distances must not be measured on the result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/mesh.h"

namespace meshgauge {

struct Decimation {
  std::size_t max_triangles = 0;  // limit of the result; at least 1
  // By vertex: each cell of the grid keeps a vertex of its highest rank, so that a vertex that must be visible is not
  // lost among its neighbours or with a part that is too small for the grid. Empty: all have rank 0.
  std::span<const std::uint8_t> rank;
};

struct Decimated {
  Mesh mesh;
  std::vector<std::uint32_t> source;  // by vertex of `mesh`: its number in the given mesh
};

// Returns a mesh of at most max_triangles by vertex clustering. The vertices in one cell of a grid are replaced by the
// one of them that is nearest to their mean. So every vertex is a vertex of `mesh` at its own place, within a cell's
// diagonal of those that it stands for. Triangles within one or two cells are left out, and of those with the same
// three vertices, in either orientation, all but the first. The grid is the finest of those tried whose result fits;
// most meshes keep 60 % of max_triangles or more.
//
// If no triangle is left at a cell's vertex of a rank above 0, one of `mesh` at that vertex is added unchanged: the
// highest ranks first, as many as fit. A vertex of the highest rank of all is always in the result.
// If no grid leaves a triangle, the result consists of triangles of `mesh`: for vertices with a rank, then the largest.
//
// The result passes validate(), and has area if `mesh` has. Deterministic. nullopt: `mesh` has at most max_triangles,
// or interrupted. Linear time, ten to twenty passes. Precondition: `mesh` passes validate(); `rank` is empty or has an
// entry for each vertex.
std::optional<Decimated> decimated(MeshView mesh, const Decimation& wanted,
                                   const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
