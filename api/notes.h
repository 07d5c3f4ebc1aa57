// What was done to a mesh beyond reading it, and to a pair beyond measuring it, in words.
#pragma once

#include <string>
#include <vector>

#include "api/compare.h"

namespace meshgauge::api {

// One sentence each, with its count where there is one; nothing for what did not happen. The rules are those of
// docs/formats.md.
std::vector<std::string> notes_of(const MeshFacts& mesh);

// What concerns both: the units that were taken, and sizes that look like a mistake of units. Likewise.
std::vector<std::string> notes_of(const Comparison& comparison);

}  // namespace meshgauge::api
