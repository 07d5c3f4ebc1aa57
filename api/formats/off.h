// Reads OFF; normals, colours and texture coordinates are ignored.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Returns the place after a byte order mark, blanks, blank lines and comments.
const char* start_of_content(std::string_view text);

// Returns the keyword ("OFF", "COFF", "STCNOFF", "4OFF", ...) after any blanks, blank lines and comments; counts may
// follow without a space ("OFF8 6 12"). Empty: no keyword.
std::string_view off_keyword(std::string_view text);

// Reads OFF with any of the prefixes ST, C and N, in any order; each adds numbers to the line of a vertex. Accepts
// comments, blank lines, a missing edge count, faces over several lines, colours of faces and, with a remark, a file
// without the keyword whose first line has the counts, and NUL or 0x1A bytes at the end. Binary files:
// api/formats/off_binary.h. Refuses other kinds (4OFF, nOFF) and other objects of Geomview (LIST, MESH) by name. Linear
// time.
Result<ReadMesh> read_off(const Source& source);

}  // namespace meshgauge::api
