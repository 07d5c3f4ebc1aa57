// Turns the bytes of a mesh file into a mesh, whose vertices of equal position are merged where the format stores three
// vertices for each triangle. The service does so in a sandbox.
#pragma once

#include <cstddef>
#include <span>

#include "api/formats/format.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

// Merges vertices whose three coordinates are equal (-0.0 equals 0.0 and becomes 0.0). Keeps the order in which
// positions first occur, and every triangle, also those that become degenerate. Returns the number of vertices removed.
// Precondition: indices in range, no NaN. Expected linear time for any positions; allocates two arrays of indices.
std::size_t weld(Mesh& mesh);

// Calls read_mesh(), then weld() if every triangle has three vertices of its own. Guarantees and errors: as for
// read_mesh().
Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits);

}  // namespace meshgauge::api
