// The extensions of a glTF: read, without effect on the surface, or refused.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf_document.h"

namespace meshgauge::api {

// Moves the extensions, the strides of views and each primitive's indices from the members of take_gltf_members() to
// `out`. Refuses a required extension by name, unless it is read or known not to affect the surface.
Result<Done> take_gltf_extensions(const Source& source, nlohmann::json& root, GltfDocument& out);

// Returns true when a buffer only replaces data that meshopt compresses.
bool is_gltf_fallback(const nlohmann::json& buffer);

}  // namespace meshgauge::api
