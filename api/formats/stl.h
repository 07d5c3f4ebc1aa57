// Reads STL, binary and ASCII.
#pragma once

#include "api/formats/source.h"
#include "api/formats/stl_binary.h"  // is_binary_stl()

namespace meshgauge::api {

// Reads either kind, told apart by size and content; "solid" at the start is not trusted. Each facet gets three
// vertices of its own, in the file's order; weld() merges them. Normals and colours are not used.
Result<ReadMesh> read_stl(const Source& source);

}  // namespace meshgauge::api
