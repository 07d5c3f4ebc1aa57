// Reads OFF; normals, colours and texture coordinates are ignored.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Returns the keyword ("OFF", "COFF", "STCNOFF", "4OFF", ...) after any blanks, blank lines and comments; counts may
// follow without a space ("OFF8 6 12"). Empty: no keyword.
std::string_view off_keyword(std::string_view text);

// Reads OFF with any of the prefixes ST, C and N, in any order; each adds numbers to the line of a vertex. Accepts
// comments, blank lines, a missing edge count, faces over several lines, colours of faces and, with a remark, a file
// without the keyword whose first line has the counts. Binary files: api/formats/off_binary.h. Refuses other kinds
// (4OFF, nOFF) by name. Linear time.
Result<ReadMesh> read_off(const Source& source);

}  // namespace meshgauge::api
