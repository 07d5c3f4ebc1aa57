// Writes outcomes as GitLab's Code Quality report, which merge requests show: a list of findings in the form of Code
// Climate.
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// Returns a finding for each gate that did not pass, at its line of the manifest. Severity: critical for an error,
// major for a fail or an undecided that counts, minor for a fail and info for an undecided that are allowed.
std::string to_code_quality(const Report& report);

}  // namespace meshgauge::check
