// The candidate of a gate with its distance from the baseline at every vertex, ready to be written: as PLY
// (api/deviation_ply.h) or GLB (api/deviation_glb.h).
//
// The candidate is whichever of two meshes is shown; the baseline is the other one. Distances are measured from the
// candidate alone. What the baseline has and the candidate lacks is not on the
// candidate, so no vertex shows it: the witness does.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "api/colour_map.h"
#include "api/result_document.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// What is shown of the candidate.
enum class MapForm {
  as_is,
  refined,    // with more vertices (engine/refinement.h); the candidate's own come first
  decimated,  // with fewer (engine/decimation.h); each is one of the candidate's
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
  std::optional<ResultWitness> witness;
  std::optional<ResultDirection> direction;  // if it was measured
};

}  // namespace meshgauge::api
