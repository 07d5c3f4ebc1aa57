// Reads XYZ: a point cloud as text, one point a line.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// A line holds x, y and z, separated by blanks; what follows on it (normals, colours) is ignored. Skips empty lines,
// comments from # to the end of the line, and a byte order mark; with a remark, before the points, a heading that
// begins with X Y Z and a count of the points, and NUL or 0x1A bytes at the end. Refuses a heading of other columns and
// a wrong count. Linear time.
Result<ReadMesh> read_xyz(const Source& source);

}  // namespace meshgauge::api
