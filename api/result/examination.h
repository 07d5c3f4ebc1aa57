// Holds what is expected of mesh a against what was found of it.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/compare/compare.h"
#include "api/options/expectations.h"
#include "api/result/criteria.h"
#include "api/result/verdict.h"

namespace meshgauge::api {

// Returns an expectation: "triangles", "24512", "at most 20000". undecided: the time ended before it was known, or
// rounding leaves it open.
Criterion expectation(std::string name, Verdict verdict, std::string found, std::string expected, bool in_time = true);

// Name, verdict, found and expected of each.
nlohmann::ordered_json expectations_json(const std::vector<Criterion>& expectations);

// Returns what is expected with what the `meshes` of a result document say of it. `unit`: of the result's lengths, or
// empty. With of_topology(), a mesh without `topology` was not examined in time.
std::vector<Criterion> examined(const Expectations& expect, const nlohmann::ordered_json& meshes,
                                const std::string& unit);

// Returns what the options expect of mesh a, and what was found. Empty: nothing is expected.
std::vector<Criterion> expectations_of(const Comparison& comparison);

}  // namespace meshgauge::api
