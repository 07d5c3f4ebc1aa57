// Reads `expect` of a gate, in a manifest or of a flag.
#pragma once

#include <string_view>

#include "check/manifest/settings.h"

namespace meshgauge::check {

void read_expect(const Setting& setting, Draft& draft, Mistakes& mistakes);

// Parses expectations as a flag, a map as in a manifest: "{watertight: true, triangles: {max: 20000}}".
Result<Expectations> parse_expect(std::string_view text);

}  // namespace meshgauge::check
