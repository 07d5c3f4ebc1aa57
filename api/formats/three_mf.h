// Reads 3MF: a zip archive with models in XML.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

inline constexpr const char* kRelationships = "_rels/.rels";  // an entry of every 3MF package

// Reads the triangles of the build's items, components and instances with their transforms, in the model's unit
// (ReadNotes::unit); without transforms the coordinates are the file's own, bit-equal to strtod. Objects outside the
// build are counted and left out. Reads from memory, part by part; opens nothing outside the bytes. Refuses cycles of
// components, nesting beyond 64 and more than a million placed objects and components.
Result<ReadMesh> read_3mf(const Source& source);

}  // namespace meshgauge::api
