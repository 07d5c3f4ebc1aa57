// What is expected of mesh a itself, beside its distance to mesh b.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/result.h"

namespace meshgauge::api {

enum class Verdict;

// Both ends are part of it; nullopt: no end.
struct Span {
  std::optional<double> min, max;

  bool operator==(const Span&) const = default;
};

// nullopt: nothing is expected.
struct Expectations {
  std::optional<bool> watertight, oriented;
  std::optional<Span> triangles, degenerate, components;
  std::optional<Span> volume;           // in the cube of the unit of the result
  std::optional<double> volume_within;  // of mesh b's volume: 0.01 is one percent

  bool operator==(const Expectations&) const = default;
  bool any() const { return *this != Expectations(); }
  // Whether the comparison has to examine the topology of the meshes.
  bool of_topology() const { return watertight || oriented || components || volume || volume_within; }
};

// One expectation, and what was found.
struct Expectation {
  std::string name;      // "watertight", "triangles", ...
  Verdict verdict;       // undecided: the time ended before it was known, or rounding leaves it open
  std::string found;     // "24512", "no: 4 open edges, the first at (0.5, 0, 1) mm"
  std::string expected;  // "at most 20000", "yes"
  bool known{true};      // false: the time ended before anything was
};

nlohmann::ordered_json json_of(const std::vector<Expectation>& expectations);
// Writes it as a request has it, members in a fixed order: a count of one value as a number.
nlohmann::ordered_json json_of(const Expectations& expect);

// Returns what is expected with what the `meshes` of a result document say of it. `unit`: of the result's lengths, or
// empty. With of_topology(), a mesh without `topology` was not examined in time.
std::vector<Expectation> examined(const Expectations& expect, const nlohmann::ordered_json& meshes,
                                  const std::string& unit);

}  // namespace meshgauge::api
