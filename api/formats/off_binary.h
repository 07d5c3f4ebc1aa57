// Reads binary OFF, as Geomview defines it and in the variants that other programs write.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Number of 4-byte numbers that follow the coordinates of a vertex.
struct OffExtras {
  int normal = 0;
  int colour = 0;
  int texture = 0;
};

// Reads from `body`, the first byte after the keyword's line. Geomview writes big-endian integers and floats of four
// bytes, and the number of colour components after each face. Other programs write little-endian, or omit that number.
// Uses the first of these variants for which counts, faces and the file's size agree to the byte, with a remark unless
// it is Geomview's. Refuses a file that none of them fits. Linear time.
Result<ReadMesh> read_binary_off(const Source& source, const char* body, const OffExtras& extras);

}  // namespace meshgauge::api
