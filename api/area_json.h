// Writes certified areas as JSON.
#pragma once

#include "api/json_of.h"
#include "engine/area.h"

namespace meshgauge::api {

Json json_of(const AreaOutcome& areas);

}  // namespace meshgauge::api
