// Reads ASCII STL.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Reads one solid or more. Lines may be joined, and a byte order mark may precede them. An `endsolid` that is joined to
// a name, and a file that ends after a facet without it, get a remark. Precondition: the text begins with "solid".
Result<ReadMesh> read_ascii_stl(const Source& source);

}  // namespace meshgauge::api
