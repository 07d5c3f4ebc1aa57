// Regions of a measurement in JSON: asked for, and measured.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/comparison_options.h"
#include "api/json_of.h"
#include "engine/outcome.h"
#include "engine/region.h"
#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::string_view kRest = "rest";  // the name of what is in no region

// As a request has it.
Json json_of(const Region& region);

// What was measured, in the order of Outcome::regions.
Json regions_of(const Outcome& outcome, const ComparisonOptions& options);

}  // namespace meshgauge::api
