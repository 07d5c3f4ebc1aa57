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

// Reads an array of 1 to Region::kMost regions: {"name": "bore", "box": {"min": [x, y, z], "max": [x, y, z]}},
// {"name": "tip", "sphere": {"centre": [x, y, z], "radius": r}} or {"name": "lid", "group": "Lid"}, whose ranges are
// not known yet; each with an optional max_distance. Error: invalid_request, with a JSON pointer from `pointer` on.
Result<std::vector<Region>> read_regions(const nlohmann::json& value, const std::string& pointer);

// Checks names, shapes and numbers; `pointer` as above. read_regions() has done so.
Result<Done> check_regions(const std::vector<Region>& regions, const std::string& pointer);

// Refuses a limit of a region without one for the rest.
Result<Done> check_limits_of_regions(const ComparisonOptions& options, std::string_view name);

// Refuses a group where nothing is measured from mesh b. `pointer` as above.
Result<Done> check_groups(const ComparisonOptions& options, const std::string& pointer);

// As read_regions() reads it.
Json json_of(const Region& region);

// What was measured, in the order of Outcome::regions.
Json regions_of(const Outcome& outcome, const ComparisonOptions& options);

}  // namespace meshgauge::api
