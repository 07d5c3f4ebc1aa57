// Reads glTF 2.0: JSON with data URIs (.gltf), GLB, or a zip archive of a .gltf and its files.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Reads the triangles of the default scene (else of the first scene, else of all root nodes), with node transforms
// applied in double precision, skinned meshes in the pose of their joints' nodes and morph targets at their default
// weights. Opens nothing outside the bytes. Refuses unknown required extensions by name. Throws nothing.
Result<ReadMesh> read_gltf(const Source& source, Format format);

}  // namespace meshgauge::api
