// One picture of a comparison, as a PNG.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "api/compare/compare.h"
#include "check/outcome.h"
#include "cli/mcp/message.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::mcp {

struct Picture {
  std::vector<std::byte> png;
  Json about;         // which mesh it shows, its size, and where the witness is in it
  std::string words;  // the same as a sentence
};

// Draws the mesh on which the witness lies, coloured by its distance to the other one, on white, with a ring around the
// witness. Precondition: something was measured, and its document names these meshes. Errors: of what stops it.
Result<Picture> picture_of(const check::GateOutcome& outcome, const api::SharedMeshes& meshes, unsigned threads,
                           Control& control);

}  // namespace meshgauge::mcp
