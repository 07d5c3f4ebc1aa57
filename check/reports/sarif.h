// Writes outcomes as SARIF 2.1.0, for GitHub's code scanning and other viewers.
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// Each gate that did not pass is a result at its line of the manifest (without a manifest: at the candidate), with
// both files as related locations. Level: error for what counts, warning for a fail and note for an undecided that
// are allowed. Passed gates are counted in the run's properties, since viewers take every result for a finding.
//
// The fingerprint is fingerprint_of() (finding.h).
std::string to_sarif(const Report& report);

}  // namespace meshgauge::check
