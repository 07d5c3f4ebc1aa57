// Writes the report as JSON (docs/check.md).
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// Returns indented JSON with members in a fixed order and a final line end. Numbers round-trip, non-finite ones
// become null, bytes that are not UTF-8 become U+FFFD. `comparison` of a gate is the answer of POST /v1/comparisons.
std::string to_json(const Report& report);

}  // namespace meshgauge::check
