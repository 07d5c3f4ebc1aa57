// Counts what the JSON of a glTF says of the surface and the reader does not read.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf_document.h"

namespace meshgauge::api {

// Adds to out.unread the extensions on meshes, primitives and nodes that are or change surface, or are unknown, and
// materials that displace it; to out.remarks animations and alternatives. Sets GltfFaces::foreign. Precondition:
// take_gltf_extensions() has taken the faces of `whole`.
void count_gltf_unread(const nlohmann::json& whole, GltfDocument& out);

}  // namespace meshgauge::api
