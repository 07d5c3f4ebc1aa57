// OFF in text: with normals, colours and texture coordinates, which are passed over.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// The keyword at the start ("OFF", "COFF", "STCNOFF", "4OFF", ...); empty when there is none.
std::string_view off_keyword(std::string_view text);

// Kinds are OFF with any of the prefixes ST, C and N, in any order: so many more numbers stand on the line of a vertex.
// Comments, blank lines, a missing edge count and colours of faces are taken. Other kinds (4OFF, nOFF, binary) are
// refused by name. Linear time.
Result<ReadMesh> read_off(const Source& source);

}  // namespace meshgauge::api
