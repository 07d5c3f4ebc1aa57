// The outcomes as SARIF 2.1.0, for GitHub's code scanning and other viewers of findings.
#pragma once

#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// Each gate that did not pass is a result at its line of the manifest, with the two files as related locations; without
// a manifest it is at the candidate. Level: error for what counts, warning for a fail and note for an undecided that
// are allowed. Passed gates are counted in the run's properties: viewers take every result for a finding.
//
// The fingerprint is made of the manifest's and the gate's name: a finding stays the same one while its distance
// changes, and another one than its neighbours of the same glob and line.
std::string to_sarif(const Report& report);

}  // namespace meshgauge::check
