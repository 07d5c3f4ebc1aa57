// Reads PLY 1.0: ASCII, binary little endian and binary big endian.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Reads the elements "vertex" (x, y, z of any type), "face" and "tristrips" (vertex_indices or vertex_index, a list of
// any integer type; -1 ends a strip), in any order. Other elements and lists that may be surface are unread, the rest
// is ignored. Without anything that may join vertices it is a point cloud. Linear time.
Result<ReadMesh> read_ply(const Source& source);

}  // namespace meshgauge::api
