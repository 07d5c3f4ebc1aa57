// STL, binary and ASCII.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// True when the bytes can only be a binary STL: the size is what the count of facets at byte 80 asks for, exactly or,
// with facets, up to 80 bytes more. No text has a count at byte 80 that fits its size.
bool is_binary_stl(std::span<const std::byte> bytes);

// Binary or ASCII is told by size and content; "solid" at the start is never trusted. Three vertices of its own
// for each facet, in the file's order; weld() joins them. Normals, colours and attributes are not used. Bytes behind
// the last facet of a binary file (up to 80) and an ASCII file that ends behind a facet, without endsolid, get a
// remark. The lines of an ASCII file may be joined.
Result<ReadMesh> read_stl(const Source& source);

}  // namespace meshgauge::api
