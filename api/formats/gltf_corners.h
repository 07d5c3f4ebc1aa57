// The corners of a primitive, as indices of its vertices.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/formats/gltf_file.h"

namespace meshgauge::api {

// Returns the indices of a primitive; all its vertices in order if it has none. Refuses an index without a vertex, and
// the largest index of its type, which restarts a primitive. `where`: the primitive in messages.
Result<std::vector<std::uint32_t>> gltf_corners(const GltfFile& file, const GltfFaces& faces, const std::string& where,
                                                std::size_t vertices);

}  // namespace meshgauge::api
