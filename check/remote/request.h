// What a gate asks the service for.
#pragma once

#include <string>

#include "check/gate.h"

namespace meshgauge::check::service {

// The document of POST /v1/comparisons (openapi.yaml, "StoredPair"): the meshes' ids, and what the same gate measured
// here is measured with. `max_distance` in the meshes' unit. Threads are the service's to say unless the gate does.
std::string pair_document(const std::string& a, const std::string& b, const Gate& gate, double max_distance);

}  // namespace meshgauge::check::service
