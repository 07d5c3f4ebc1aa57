// The surface of a glTF: the meshes of its scene, placed by its nodes.
#pragma once

#include "api/formats/gltf/gltf_file.h"

namespace meshgauge::api {

// Reads the triangles of the default scene, else of the first scene, else of all root nodes; a scene of points
// alone is a point cloud. The caller sets the format of the result.
Result<ReadMesh> read_gltf_scene(const GltfFile& file);

}  // namespace meshgauge::api
