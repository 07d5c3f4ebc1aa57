// Writes certified areas and sides as JSON.
#pragma once

#include "api/json_of.h"
#include "engine/area.h"
#include "engine/sides.h"

namespace meshgauge::api {

Json json_of(const AreaOutcome& areas);
Json json_of(const SideOutcome& sides, const std::optional<LengthUnit>& unit);

// Returns "mesh b is open: an edge at (0.5, 0, 1) mm has one triangle" or the like.
std::string in_words(const NoSides& refused, const std::optional<LengthUnit>& unit);

}  // namespace meshgauge::api
