// What a gate asks the service for.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "check/gate.h"

namespace meshgauge::check::service {

// The document of POST /v1/comparisons (openapi.yaml, "StoredPair"): the meshes' ids, and what the same gate measured
// here is measured with. `max_distance` is the gate's limit, a share already in numbers. Threads are the service's to
// say unless the gate does.
nlohmann::ordered_json asked_of(const std::string& a, const std::string& b, const Gate& gate, double max_distance);

// As text; what is not UTF-8 is replaced.
std::string document_of(const nlohmann::ordered_json& asked);

}  // namespace meshgauge::check::service
