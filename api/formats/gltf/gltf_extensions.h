// The extensions of a glTF: which are known here and what each means for the surface; those that are read, without
// effect on it, or refused; and what the JSON says of the surface that is not read.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf/gltf_document.h"

namespace meshgauge::api {

// Moves the extensions, the strides of views and each primitive's indices from `root`, the checked members, to `out`.
// Refuses a required extension by name, unless it is read or known not to affect the surface.
Result<Done> take_gltf_extensions(const Source& source, nlohmann::json& root, GltfDocument& out);

// Returns true when a buffer only replaces data that meshopt compresses.
bool is_gltf_fallback(const nlohmann::json& buffer);

// Adds to out.unread the extensions on meshes, primitives and nodes that are or change surface, or are unknown, and
// materials that displace it; to out.remarks animations and alternatives. Sets GltfFaces::foreign. Precondition:
// take_gltf_extensions() has taken the faces of `whole`.
void count_gltf_unread(const nlohmann::json& whole, GltfDocument& out);

}  // namespace meshgauge::api
