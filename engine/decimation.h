// Fewer triangles that look like the same surface, for display: nothing may be measured on them.
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
  std::size_t max_triangles = 0;  // never more; at least 1
  // By vertex: in a cell of the grid one of the highest rank is kept, so that what must be seen is not lost between its
  // neighbours, nor with a part that is too small for the grid. Empty: all alike.
  std::span<const std::uint8_t> rank;
};

struct Decimated {
  Mesh mesh;
  std::vector<std::uint32_t> source;  // by vertex of it: the same vertex of the mesh that was given
};

// Vertex clustering: the vertices in one cell of a grid become one of them, the one nearest to their mean. So every
// vertex is one of `mesh`, at its own place, and no more than a cell's diagonal from those that it stands for.
// Triangles within one or two cells go, and all but the first of those with the same three vertices, whichever way they
// face. The grid is the finest of those tried that leaves few enough; most meshes keep 60 % of max_triangles or more.
// A cell with a vertex of a rank above 0 that has no triangle left is shown by one of `mesh` at that vertex, as it is,
// the highest ranks first, as many as fit. One of the highest rank of all is always there.
// Where no grid leaves a triangle, some of `mesh` are kept as they are: for vertices of a rank, and the largest.
//
// Passes validate(), and has area where `mesh` has. Deterministic. nullopt: `mesh` has no more triangles than that, or
// `interrupted` said so. Linear time, some ten passes, or twice that. Precondition: passes validate(), and so many
// ranks as vertices or none.
std::optional<Decimated> decimated(MeshView mesh, const Decimation& wanted,
                                   const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
