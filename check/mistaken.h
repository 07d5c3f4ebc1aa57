// The report of a run that did not begin: so that who reads the reports, and not the log, sees why, and never takes
// those of an earlier run for this one's.
#pragma once

#include <string>
#include <vector>

#include "check/manifest/mistake.h"
#include "check/outcome.h"

namespace meshgauge::check {

// An outcome for each mistake: an error, named by its place ("gates.yaml:7:5") and without meshes. `manifest`: empty
// when it is none of a manifest.
Report mistaken(const std::string& manifest, const std::vector<Mistake>& mistakes);

}  // namespace meshgauge::check
