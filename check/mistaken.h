// Report of a run that did not begin. It is written so that the reports show the mistakes and no older report is
// taken for this run's.
#pragma once

#include <string>
#include <vector>

#include "check/manifest/mistake.h"
#include "check/outcome.h"

namespace meshgauge::check {

// Returns a report with one outcome for each mistake: an error, named by its place ("gates.yaml:7:5"), without
// meshes. `manifest`: empty if the mistakes are not in a manifest.
Report mistaken(const std::string& manifest, const std::vector<Mistake>& mistakes);

}  // namespace meshgauge::check
