// The surface of a glTF: what its scene shows, placed by its nodes.
#pragma once

#include <tiny_gltf.h>

#include "api/formats/gltf_accessor.h"
#include "api/formats/source.h"

namespace meshgauge::api {

// The triangles of the default scene, else of the first, else of all root nodes. Precondition: the model comes from
// check_gltf(). The format of the result is left to the caller.
Result<ReadMesh> read_gltf_scene(const Source& source, const tinygltf::Model& model, const GltfAccessors& accessors);

}  // namespace meshgauge::api
