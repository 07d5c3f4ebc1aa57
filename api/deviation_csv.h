// Writes a deviation map as CSV (RFC 4180, but lines end in LF): x,y,z,distance and, with sides, signed_distance, nan
// where it is not proved, and, with normals, nx,ny,nz; a line for each vertex, in the order of the mesh. Where signs
// were asked for and there are none, the last column is no_sides: the reason on the first line, nothing on the others.
// Numbers are the shortest texts that read back as the same double.
#pragma once

#include <ostream>

#include "api/deviation_map.h"

namespace meshgauge::api {

// The caller checks the state of `out`.
void write_deviation_csv(const DeviationMap& map, std::ostream& out);

}  // namespace meshgauge::api
