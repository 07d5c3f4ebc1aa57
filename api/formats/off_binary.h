// OFF in binary, as Geomview defines it and as others write it.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// How many numbers of four bytes follow the coordinates of a vertex.
struct OffExtras {
  int normal = 0;
  int colour = 0;
  int texture = 0;
};

// `body`: the first byte after the line of the keyword. Geomview writes integers and floats of four bytes, the most
// significant first, and the number of colour components behind each face. Files of other programs have the least
// significant first, or no such number. Taken is the first of these ways in which counts, faces and the size of the
// file agree to the byte; where it is not Geomview's, a remark says so. Refused: a file that none of them fits.
// Linear time.
Result<ReadMesh> read_binary_off(const Source& source, const char* body, const OffExtras& extras);

}  // namespace meshgauge::api
