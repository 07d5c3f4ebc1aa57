// OFF and COFF, ASCII.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// The keyword at the start ("OFF", "COFF", "NOFF", "4OFF", ...); empty when there is none.
std::string_view off_keyword(std::string_view text);

// Comments, blank lines, a missing edge count and colours of vertices and faces are taken. Other kinds (STOFF,
// NOFF, 4OFF, nOFF, binary) are refused by name. Linear time.
Result<ReadMesh> read_off(const Source& source);

}  // namespace meshgauge::api
