// The members of a glTF's JSON that are read, with their types and ranges.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/formats/source.h"

namespace meshgauge::api {

// Returns the members that make up the surface, buffers and extensions included, without all others. Errors name the
// member. Precondition: not nested too deep for recursion.
Result<nlohmann::json> take_gltf_members(const Source& source, const nlohmann::json& document);

}  // namespace meshgauge::api
