// Formats certified areas, a few lines for each direction, and sides.
#pragma once

#include <optional>
#include <string>

#include "api/units.h"
#include "engine/area.h"
#include "engine/sides.h"

namespace meshgauge::cli {

// `unit`: unit of every length.
std::string to_table(const AreaOutcome& areas, const std::optional<api::LengthUnit>& unit);
std::string to_table(const SideOutcome& sides, const std::optional<api::LengthUnit>& unit);

}  // namespace meshgauge::cli
