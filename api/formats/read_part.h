// Turns the bytes of a mesh file into a mesh. The service does so in a sandbox.
#pragma once

#include <cstddef>
#include <span>

#include "api/formats/format.h"
#include "engine/result.h"

namespace meshgauge::api {

// Calls read_mesh(), then weld() if every triangle has three vertices of its own. Guarantees and errors: as for
// read_mesh().
Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits);

}  // namespace meshgauge::api
