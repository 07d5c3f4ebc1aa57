// One gate: two files and the distance that they may have. The central type of `meshgauge check`.
//
//   gates.yaml -> read_manifest -> expand (globs, names) -> Gate ... -> run (here, or by a service) -> GateOutcome ...
//   -> Report -> terminal, JSON, JUnit, SARIF, Markdown, HTML, exit code
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "api/comparison_options.h"
#include "engine/options.h"

namespace meshgauge::check {

using api::LengthUnit;

// The largest distance that passes. Exactly one of the two is given.
struct Limit {
  std::optional<double> max_distance;        // in `unit`; without one in the unit of the result (docs/units.md)
  std::optional<double> max_diagonal_share;  // of the diagonal of the baseline's bounding box: 0.01 is one percent
  std::optional<LengthUnit> unit;            // of max_distance
};

// In the unit of `baseline_diagonal`, that of the baseline's bounding box in its own unit, for a share of it.
inline double max_distance(const Limit& limit, double baseline_diagonal) {
  return limit.max_distance ? *limit.max_distance : limit.max_diagonal_share.value_or(0) * baseline_diagonal;
}

// As the engine's, but for the tolerance: a gate ends with its verdict, and not with an interval of one percent that
// the limit may lie in.
inline Options gate_options() {
  Options options;
  options.tolerance = {std::nullopt, 1e-9, std::nullopt};
  return options;
}

// `candidate` is mesh a, `baseline` mesh b: a_to_b is from the candidate to the baseline.
struct Gate {
  std::string name;                 // unique in a run
  std::filesystem::path candidate;  // as a person would write it: relative to the current folder where it can be
  std::filesystem::path baseline;
  Limit limit;
  // direction, strategy, points, tolerance, threads, and the units declared of the meshes; max_distance and the unit of
  // the limit come from `limit`.
  api::ComparisonOptions options = gate_options();
  bool threads_given = false;                 // else the run says how many
  std::chrono::milliseconds timeout{30'000};  // of the whole gate
  bool warn_only = false;                     // a fail or an undecided is shown and does not count
  bool statistics = false;
  std::string manifest;  // where it stands, for reports that point at a line; empty: it was given by flags
  int line = 0;          // 1-based
};

// What a comparison is told of the gate's units.
inline api::AskedUnits units_of(const Gate& gate) {
  api::AskedUnits units = gate.options.units;
  units.limit = gate.limit.unit;
  units.limit_of_b = gate.limit.max_diagonal_share.has_value();
  return units;
}

}  // namespace meshgauge::check
