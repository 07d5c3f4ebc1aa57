// Which members of a glTF's JSON are read, and of what type and range each must be.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/formats/source.h"

namespace meshgauge::api {

// The members that make the surface, buffers and extensions included; all others are dropped. An Error names the
// member. Precondition: not nested too deep for recursion.
Result<nlohmann::json> take_gltf_members(const Source& source, const nlohmann::json& document);

}  // namespace meshgauge::api
