// The setting `regions` of a gate.
#pragma once

#include <string_view>
#include <vector>

#include "check/manifest/settings.h"

namespace meshgauge::check {

void read_regions(const Setting& setting, Draft& draft, Mistakes& mistakes);

// Parses regions as a flag, a list as in a manifest: "[{name: bore, box: {min: [0, 0, 0], max: [1, 1, 1]}}]".
Result<std::vector<RegionLimit>> parse_regions(std::string_view text);

}  // namespace meshgauge::check
