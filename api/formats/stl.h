// Reads STL, binary and ASCII.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Returns true when the bytes can only be a binary STL: the count of facets at byte 80 gives the file's size, exactly
// or, with facets, up to 80 bytes less. No text has a count at byte 80 that fits its size.
bool is_binary_stl(std::span<const std::byte> bytes);

// Reads either kind, told apart by size and content; "solid" at the start is not trusted. Each facet gets three
// vertices of its own, in the file's order; weld() merges them. Normals, colours and attributes are not used. Up to 80
// bytes after the last facet of a binary file, and an ASCII file that ends after a facet without endsolid, get a
// remark. The lines of an ASCII file may be joined.
Result<ReadMesh> read_stl(const Source& source);

}  // namespace meshgauge::api
