// 3MF: a zip archive with models in XML.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

inline constexpr const char* kRelationships = "_rels/.rels";  // a file of every 3MF package

// The triangles that the build shows, components and instances with their transforms, in the model's own unit
// (ReadNotes::unit); without transforms the coordinates are the file's own, bit-equal to strtod.
// Objects outside of the build are counted and not read into the mesh. Read from memory, part by part; nothing outside
// the bytes is opened. Refused: cycles of components, 64 of them inside each other, a million placed in all.
Result<ReadMesh> read_3mf(const Source& source);

}  // namespace meshgauge::api
