// What a gate expects of the candidate mesh itself, beside its distance to the baseline.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::check {

struct GateOutcome;
enum class Verdict;

// Both ends are part of it; nullopt: no end.
struct Span {
  std::optional<double> min, max;
};

// nullopt: nothing is expected.
struct Expectations {
  std::optional<bool> watertight, oriented;
  std::optional<Span> triangles, degenerate, components;
  std::optional<Span> volume;           // in the cube of the unit of the gate's lengths
  std::optional<double> volume_within;  // of the baseline's volume: 0.01 is one percent

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

// Returns what is expected of the gate's candidate with what the comparison's document says of it. Empty without a
// measurement.
std::vector<Expectation> examined(const GateOutcome& outcome);

}  // namespace meshgauge::check
