// --deviation FILE: the candidate coloured by its distance from the baseline.
#pragma once

#include <filesystem>

#include "check/gate.h"
#include "check/outcome.h"
#include "engine/control.h"
#include "engine/prepared.h"
#include "engine/result.h"

namespace meshgauge::check {

// Readers that show colours alone see nothing of what lies between vertices: a dent under the middle of a cube's face
// is invisible. Refining splits edges longer than a 64th of the candidate's diagonal, for display, to at most 250,000
// triangles; a mesh of more is written as it is.
enum class Refine {
  by_format,  // .glb is for looking: refined. .ply is for computing: one scalar for each vertex of the candidate.
  never,
  always,
};

struct DeviationFile {
  std::filesystem::path path;  // .ply (api/deviation_ply.h) or .glb (api/deviation_glb.h), in any case
  Refine refine = Refine::by_format;
  unsigned threads = 1;
};

// Whether the name says which format; invalid_request otherwise. For asking before anything is measured.
Result<Done> check_deviation_name(const std::filesystem::path& path);

// Measures the distances and writes the file: under another name in the same folder first, so that what is at `path` is
// whole. The limit is the end of the colour map, what is above it has another colour. Whatever the gate's direction,
// the distances are from the candidate to the baseline, and never above what is certified of them, so a gate that
// passes shows none above its limit; what the candidate lacks, the witness shows. `control` is for this work alone, not
// that of the measurement, whose deadline may have passed; out_of_time when it says to stop.
// Both meshes are in the unit of `measured` (api::in_unit).
Result<Done> write_deviation(const DeviationFile& file, const Prepared& candidate, const Prepared& baseline,
                             const Measured& measured, Control& control);

}  // namespace meshgauge::check
