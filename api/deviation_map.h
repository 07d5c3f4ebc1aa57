// The candidate of a gate with its distance from the baseline at every vertex, ready to be written: as PLY
// (api/deviation_ply.h) or GLB (api/deviation_glb.h).
//
// The candidate is whichever of two meshes is shown; the baseline is the other one. Distances are measured from the
// candidate alone. What the baseline has and the candidate lacks is not on the
// candidate, so no vertex shows it: the witness does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "api/colour_map.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// Where the distance is at least `lower`: a point of one mesh, and the point of the other that is nearest to it.
struct DeviationWitness {
  bool from_candidate = true;  // `from` lies on the candidate
  Vec3 from = Vec3::Zero();
  std::uint32_t from_triangle = 0;  // 0-based, of the files
  Vec3 to = Vec3::Zero();
  std::uint32_t to_triangle = 0;
};

// What is shown of the candidate.
enum class MapForm {
  as_is,
  refined,    // with more vertices (engine/refinement.h); the candidate's own come first
  decimated,  // with fewer (engine/decimation.h); each is one of the candidate's
};

// What is certified of the way from the candidate to the baseline alone.
struct DeviationDirection {
  double lower = 0;
  double upper = 0;
  std::optional<DeviationWitness> witness;
};

// Borrows the mesh and the distances.
struct DeviationMap {
  MeshView mesh;  // passes validate(); the candidate, as `form` says
  MapForm form = MapForm::as_is;
  std::size_t candidate_vertices = 0;  // of the candidate itself, whatever is shown of it
  std::size_t candidate_triangles = 0;
  std::span<const double> distances;  // by vertex, in the meshes' unit; finite and >= 0 (engine/deviation.h)
  ColourScale scale;
  std::string units;  // label, may be empty
  double lower = 0;   // the certified interval of the gate
  double upper = 0;
  std::optional<DeviationWitness> witness;
  std::optional<DeviationDirection> direction;  // if it was measured
};

}  // namespace meshgauge::api
