// The surface of a glTF: what its scene shows, placed by its nodes.
#pragma once

#include "api/formats/gltf_file.h"
#include "api/formats/source.h"

namespace meshgauge::api {

// The triangles of the default scene, else of the first, else of all root nodes. The format of the result is left to
// the caller.
Result<ReadMesh> read_gltf_scene(const GltfFile& file);

}  // namespace meshgauge::api
