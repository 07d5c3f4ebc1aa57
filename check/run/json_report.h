// The whole report as JSON (docs/check.md).
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// Indented, members in a fixed order, a line end at the end. Numbers round-trip; what is not finite is null, and what
// is not UTF-8 becomes U+FFFD. `comparison` of a gate is what POST /v1/comparisons answers.
std::string to_json(const Report& report);

}  // namespace meshgauge::check
