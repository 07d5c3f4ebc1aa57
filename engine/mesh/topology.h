// Topology and volume of a mesh: whether its surface is closed and consistently oriented, of how many parts it is, and
// the volume that it encloses. The counts are exact. Vertices at the same position count as one, so that unwelded
// meshes have neighbours too. A triangle with two corners at one position has no edges to share: it is left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/scaling.h"

namespace meshgauge {

// Edges of one kind.
struct EdgeCount {
  std::size_t count = 0;
  Vec3 first = Vec3::Zero();  // the middle of the first one, rounded; not specified without one
};

// lower <= volume <= upper, certified. Negative: the triangles face inwards.
struct Volume {
  double lower = 0;
  double upper = 0;
};

struct Topology {
  std::size_t edges = 0;
  EdgeCount open;                         // edges of one triangle
  EdgeCount non_manifold;                 // edges of more than two triangles
  EdgeCount flipped;                      // edges that several triangles pass in the same direction
  std::size_t components = 0;             // parts without a common position
  std::int64_t euler_characteristic = 0;  // vertices - edges + triangles
  // The sum over the triangles of the signed volume of the tetrahedron to any one point: what several shells enclose
  // counts by how often it is enclosed. In the cube of the mesh's unit. nullopt: not watertight, or not oriented.
  std::optional<Volume> volume;

  // Whether each edge is one of exactly two triangles.
  bool watertight() const { return edges > 0 && open.count == 0 && non_manifold.count == 0; }
  // Whether no edge is passed twice in the same direction.
  bool oriented() const { return flipped.count == 0; }
};

// Linear time; at most 24 bytes for each triangle and 20 for each vertex, until it returns. nullopt: `interrupted`,
// which is polled every few milliseconds. Precondition: the mesh passes validate(), and `box` is bounding_box(mesh).
std::optional<Topology> topology(MeshView mesh, const Box& box, const Interrupted& interrupted = never_interrupted);

// Converts places and volume to another unit, the volume outwards.
Topology scaled(Topology topology, const Factor& factor);

}  // namespace meshgauge
