// Reads binary STL: 80 bytes of any text, a count, and 50 bytes for each facet, in little-endian order.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Returns true when the bytes can only be a binary STL: the count of facets at byte 80 gives the file's size, exactly
// or, with facets, up to 49 bytes less: less than a facet. No text has a count at byte 80 that fits its size.
bool is_binary_stl(std::span<const std::byte> bytes);

// Reads the facets. Less than a facet's 50 bytes after the last one get a remark. Refuses a count that fits the size in
// no other way, facets that attribute data follow, and big-endian numbers.
Result<ReadMesh> read_binary_stl(const Source& source);

}  // namespace meshgauge::api
