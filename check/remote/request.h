// Composes the request of a gate.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "check/gate.h"

namespace meshgauge::check::service {

// Returns the document of POST /v1/comparisons (openapi.yaml, "StoredPair"): the meshes' ids and the options with
// which this process would measure the gate. The service chooses the number of threads unless the gate does.
nlohmann::ordered_json asked_of(const std::string& a, const std::string& b, const Gate& gate, const Limits& limits);

// Serialises the document; bytes that are not UTF-8 are replaced.
std::string document_of(const nlohmann::ordered_json& asked);

}  // namespace meshgauge::check::service
