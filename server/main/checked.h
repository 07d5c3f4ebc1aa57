// What the settings of a service must be to begin with.
#pragma once

#include "engine/result.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// Returns the settings with values for `workers`, `parsers` and `simd` in place of 0 and auto, and those of
// plan_memory(). An Error names the flag of a value that is out of range, contradicts another one, or asks for an
// instruction set that this processor lacks.
Result<Settings> checked(Settings settings);

}  // namespace meshgauge::server
