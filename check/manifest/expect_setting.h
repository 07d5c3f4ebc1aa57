// Reads `expect` of a gate in a manifest.
#pragma once

#include "check/manifest/settings.h"

namespace meshgauge::check {

void read_expect(const Setting& setting, Draft& draft, Mistakes& mistakes);

}  // namespace meshgauge::check
