// More vertices on the same surface, for display: a colour at each vertex says nothing of what lies between them.
#pragma once

#include <cstddef>
#include <optional>

#include "engine/control.h"
#include "engine/mesh.h"

namespace meshgauge {

struct Refinement {
  double longest_edge = 0;        // wanted; in the mesh's unit
  std::size_t max_triangles = 0;  // never more; the longest edges are split first
};

// `mesh` with its long edges split at their middles, the same in both triangles of an edge, so that no cracks open.
// The vertices of `mesh` come first, with their numbers; triangles lose theirs. The surface is the same but for the
// rounding of midpoints, half a unit in the last place. nullopt: there is nothing to split, or no room for it.
// Precondition: passes validate(). `interrupted` ends it early, with a mesh as valid as any.
std::optional<Mesh> refined(MeshView mesh, const Refinement& wanted,
                            const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
