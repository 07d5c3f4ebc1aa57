// Measures gates in this process.
#pragma once

#include <memory>
#include <vector>

#include "check/gate.h"
#include "check/measurer.h"
#include "check/run/meshes.h"

namespace meshgauge::check {

struct LocalOptions {
  unsigned processors = 1;  // shared by the gates
  unsigned jobs = 0;        // gates at the same time; 0: one for each processor
};

// `gates`: all that will be measured, each once. `meshes` must have a turn for each gate; the measurer calls done()
// after it.
std::unique_ptr<Measurer> local(const std::vector<Gate>& gates, std::shared_ptr<Meshes> meshes,
                                const LocalOptions& options);

}  // namespace meshgauge::check
