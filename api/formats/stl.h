// STL, binary and ASCII.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// True when the bytes can only be a binary STL: the size is exactly what the triangle count at byte 80 asks for.
bool is_binary_stl(std::span<const std::byte> bytes);

// Binary or ASCII is told by size and content; "solid" at the start is never trusted. Three vertices of its own
// for each facet, in the file's order; weld() joins them. Normals, colours and attributes are not used.
Result<ReadMesh> read_stl(const Source& source);

}  // namespace meshgauge::api
