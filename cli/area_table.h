// Formats certified areas: a few lines for each direction.
#pragma once

#include <optional>
#include <string>

#include "api/units.h"
#include "engine/area.h"

namespace meshgauge::cli {

// `unit`: unit of every length.
std::string to_table(const AreaOutcome& areas, const std::optional<api::LengthUnit>& unit);

}  // namespace meshgauge::cli
