// Adds vertices on the same surface, for display: colours are per vertex and do not show what lies between two
// vertices.
#pragma once

#include <cstddef>
#include <optional>

#include "engine/control.h"
#include "engine/mesh.h"

namespace meshgauge {

struct Refinement {
  double longest_edge = 0;        // edges longer than this are split; in the mesh's unit
  std::size_t max_triangles = 0;  // limit of the result; the longest edges are split first
};

// Returns `mesh` with its long edges split in the middle, in all triangles of an edge alike, so that no cracks open.
// The vertices of `mesh` come first and keep their numbers; triangles do not. The surface is the same up to the
// rounding of midpoints, half a unit in the last place. nullopt: no edge to split, or too few max_triangles. If
// interrupted, it returns the valid mesh reached so far, or nullopt. Precondition: `mesh` passes validate().
std::optional<Mesh> refined(MeshView mesh, const Refinement& wanted,
                            const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
