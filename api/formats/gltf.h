// glTF 2.0, as JSON with data URIs (.gltf), in a GLB container, or as a zip archive of a .gltf and its files.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// The triangles of the default scene (else of the first, else of all root nodes), with node transforms applied in
// double precision; skinned meshes in the pose of their joints' nodes, morph targets at their default weights. Nothing
// outside the bytes is opened; unknown required extensions are refused by name. No exception leaves.
Result<ReadMesh> read_gltf(const Source& source, Format format);

}  // namespace meshgauge::api
