// Formats sampled statistics: for each direction a line of numbers and a histogram.
#pragma once

#include <optional>
#include <string>

#include "api/units.h"
#include "engine/statistics.h"

namespace meshgauge::cli {

// `unit`: unit of every length.
std::string to_table(const Statistics& statistics, const std::optional<api::LengthUnit>& unit);

}  // namespace meshgauge::cli
