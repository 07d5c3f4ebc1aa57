// Reads Wavefront OBJ: v and f statements. l and p are counted as skipped; other statements are ignored. A file of v
// without faces, lines, points, curves and surfaces is a point cloud.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Accepts \n, \r\n and \r line ends, a byte order mark, continuation lines, relative indices, texture and normal
// indices (not looked up), vertex weights and colours (not used), and faces before their vertices. Linear time.
Result<ReadMesh> read_obj(const Source& source);

}  // namespace meshgauge::api
