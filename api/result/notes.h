// Notes: sentences about what was done to a mesh besides reading it and to a pair besides measuring it.
#pragma once

#include <string>
#include <vector>

#include "api/compare/compare.h"

namespace meshgauge::api {

// Returns the notes of one mesh, one sentence each, with counts; none for a count of 0 (docs/formats.md).
std::vector<std::string> notes_of(const MeshFacts& mesh);

// Returns the notes of the pair: units assumed or converted, sizes that suggest a wrong unit, a limit that non-planar
// faces leave open (docs/units.md, docs/formats.md).
std::vector<std::string> notes_of(const Comparison& comparison);

}  // namespace meshgauge::api
