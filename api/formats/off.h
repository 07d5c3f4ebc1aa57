// OFF, with normals, colours and texture coordinates, which are passed over.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// The keyword ("OFF", "COFF", "STCNOFF", "4OFF", ...) that comes first but for blanks, blank lines and comments; counts
// may follow without a space ("OFF8 6 12"). Empty when there is none.
std::string_view off_keyword(std::string_view text);

// Kinds are OFF with any of the prefixes ST, C and N, in any order: so many more numbers stand on the line of a vertex.
// Comments, blank lines, a missing edge count, faces over several lines and colours of faces are taken, and so is a
// file without the keyword whose first line is the counts, with a remark. Binary files: api/formats/off_binary.h. Other
// kinds (4OFF, nOFF) are refused by name. Linear time.
Result<ReadMesh> read_off(const Source& source);

}  // namespace meshgauge::api
