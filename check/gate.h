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
#include "check/expectations.h"
#include "engine/options.h"

namespace meshgauge::check {

using api::LengthUnit;

// The largest distance that passes. Exactly one of the two is given.
struct Limit {
  std::optional<double> max_distance;  // in `unit`; without a unit, in the unit of the result (docs/units.md)
  std::optional<double>
      max_diagonal_share;          // fraction of the diagonal of the baseline's bounding box: 0.01 is one percent
  std::optional<LengthUnit> unit;  // unit of max_distance
};

// Returns the limit as a distance. `baseline_diagonal`: diagonal of the baseline's bounding box, in the baseline's
// unit; a share is a fraction of it.
inline double max_distance(const Limit& limit, double baseline_diagonal) {
  return limit.max_distance ? *limit.max_distance : limit.max_diagonal_share.value_or(0) * baseline_diagonal;
}

// The engine's defaults, with a smaller tolerance: a gate ends when its limit is decided, and an interval of one
// percent could still contain the limit. Once it is decided the interval is narrowed, so that reports say by how much a
// gate passes or fails.
inline Options gate_options() {
  Options options;
  options.tolerance = {std::nullopt, 1e-9, std::nullopt};
  options.narrow = true;
  return options;
}

// `candidate` is mesh a, `baseline` mesh b: a_to_b is from the candidate to the baseline.
struct Gate {
  std::string name;                 // unique in a run
  std::filesystem::path candidate;  // as a user would write it: relative to the current folder where possible
  std::filesystem::path baseline;
  Limit limit;
  // Holds direction, strategy, points, tolerance, threads and the declared units. max_distance and the limit's unit
  // come from `limit`.
  api::ComparisonOptions options = gate_options();
  bool threads_given = false;                 // false: the run decides
  std::chrono::milliseconds timeout{30'000};  // time limit of the whole gate
  bool warn_only = false;                     // fail and undecided are reported and do not count
  bool statistics = false;
  Expectations expect;
  std::string manifest;  // manifest that contains the gate, for reports that point at a line; empty: given by flags
  int line = 0;          // 1-based
};

// Returns the units of the gate, for api::compare().
inline api::AskedUnits units_of(const Gate& gate) {
  api::AskedUnits units = gate.options.units;
  units.limit = gate.limit.unit;
  units.limit_of_b = gate.limit.max_diagonal_share.has_value();
  return units;
}

}  // namespace meshgauge::check
