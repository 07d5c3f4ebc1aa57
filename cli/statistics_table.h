// Sampled statistics as text for people: one line of numbers and a histogram of bars for each direction.
#pragma once

#include <optional>
#include <string>

#include "api/units.h"
#include "engine/statistics.h"

namespace meshgauge::cli {

// `unit`: of every length.
std::string to_table(const Statistics& statistics, const std::optional<api::LengthUnit>& unit);

}  // namespace meshgauge::cli
