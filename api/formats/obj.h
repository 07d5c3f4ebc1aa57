// Reads Wavefront OBJ: v and f statements. Points, lines and curves are counted as skipped; free-form surfaces,
// patches, included files and unknown statements as not read (api/formats/obj_statements.h); what is no surface is
// ignored. A file of v without any of these is a point cloud.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Accepts \n, \r\n and \r line ends, a byte order mark, continuation lines, relative indices, texture and normal
// indices (not looked up), vertex weights and colours (not used), faces before their vertices and, with a remark, NUL
// or 0x1A bytes at the end. Linear time.
Result<ReadMesh> read_obj(const Source& source);

}  // namespace meshgauge::api
