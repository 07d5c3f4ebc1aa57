// Holds what is expected of mesh a against what was found of it.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/compare/compare.h"
#include "api/options/expectations.h"
#include "api/result/verdict.h"

namespace meshgauge::api {

// One expectation, and what was found.
struct Expectation {
  std::string name;      // "watertight", "triangles", ...
  Verdict verdict;       // undecided: the time ended before it was known, or rounding leaves it open
  std::string found;     // "24512", "no: 4 open edges, the first at (0.5, 0, 1) mm"
  std::string expected;  // "at most 20000", "yes"
  bool known{true};      // false: the time ended before anything was
};

nlohmann::ordered_json json_of(const std::vector<Expectation>& expectations);

// Returns what is expected with what the `meshes` of a result document say of it. `unit`: of the result's lengths, or
// empty. With of_topology(), a mesh without `topology` was not examined in time.
std::vector<Expectation> examined(const Expectations& expect, const nlohmann::ordered_json& meshes,
                                  const std::string& unit);

// Returns what the options expect of mesh a, and what was found. Empty: nothing is expected.
std::vector<Expectation> expectations_of(const Comparison& comparison);

}  // namespace meshgauge::api
