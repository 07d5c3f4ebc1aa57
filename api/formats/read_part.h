// All that is done to the bytes of a mesh file before they are a mesh: what the service does in a process apart.
#pragma once

#include <cstddef>
#include <span>

#include "api/formats/format.h"
#include "engine/result.h"

namespace meshgauge::api {

// read_mesh(), and weld() where the format repeats every corner. Promises what read_mesh() does.
Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits);

}  // namespace meshgauge::api
