// --deviation FILE of check and compare: the candidate coloured by its distance from the baseline.
#pragma once

#include <filesystem>

#include "api/result/result_document.h"
#include "engine/control.h"
#include "engine/result.h"
#include "engine/tree/prepared.h"

namespace meshgauge::check {

// Refinement, for display. Viewers show colours of vertices only, so a dent in the middle of a cube's face would be
// invisible. Refining splits edges longer than a 64th of the candidate's diagonal, up to 250,000 triangles. A larger
// mesh is written as it is.
enum class Refine {
  by_format,  // .glb is refined, since it is for viewing; others are not: one scalar for each vertex of the candidate
  never,
  always,
};

struct DeviationFile {
  std::filesystem::path path;  // .ply, .glb, .vtp or .csv (api/map/deviation_ply.h and others), in any case
  Refine refine = Refine::by_format;
  unsigned threads = 1;
  bool normals = false;  // of each vertex, as in api::MapOptions
};

// Checks that the suffix of `path` is that of a known format; invalid_request otherwise. Call it before measuring.
Result<Done> check_deviation_name(const std::filesystem::path& path);

// Measures the distances from the candidate to the baseline, whatever the gate's direction, and writes the file under
// another name first, so that the file at `path` is always complete. The colour map ends at the limit; distances
// above it have a colour of their own. No distance exceeds the certified upper bound, so a gate that passes shows
// none above its limit. What the candidate lacks is shown by the witness. `control` belongs to this work alone, since
// the measurement's deadline may have passed; out_of_time when it stops the work. Precondition: both meshes are in
// the unit of `facts` (api::in_unit).
Result<Done> write_deviation(const DeviationFile& file, const Prepared& candidate, const Prepared& baseline,
                             const api::ResultFacts& facts, Control& control);

}  // namespace meshgauge::check
