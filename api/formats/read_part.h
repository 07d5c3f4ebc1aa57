// Turns the bytes of a mesh file into a mesh, whose vertices of equal position are merged where the format stores three
// vertices for each triangle. The service does so in a sandbox.
#pragma once

#include <cstddef>
#include <span>

#include "api/formats/format.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

// Calls read_mesh(), and merges the vertices (api/formats/weld.h) if every triangle has three of its own. Guarantees
// and errors: as for read_mesh().
Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits);

}  // namespace meshgauge::api
