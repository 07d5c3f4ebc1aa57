// The extensions of a glTF: which are read, which leave the surface as it is, and which end the reading.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf_document.h"

namespace meshgauge::api {

// Moves what extensions say, and each primitive's indices, from the members of take_gltf_members() to `out`. Refuses a
// required extension by its name, unless it is read or known to leave the surface alone.
Result<Done> take_gltf_extensions(const Source& source, nlohmann::json& root, GltfDocument& out);

// Whether a buffer only stands in for what meshopt compresses.
bool is_gltf_fallback(const nlohmann::json& buffer);

}  // namespace meshgauge::api
