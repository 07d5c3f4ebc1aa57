// One gate: two files and how far they may be apart. The central type of `meshgauge check`.
//
//   gates.yaml -> read_manifest -> expand (globs, names) -> Gate ... -> run (here, or by a service) -> GateOutcome ...
//   -> Report -> terminal, JSON, JUnit, SARIF, Markdown, HTML, exit code
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/comparison_options.h"
#include "api/expectations.h"
#include "api/mesh_file.h"
#include "engine/options.h"

namespace meshgauge::check {

using api::Expectation;
using api::Expectations;
using api::LengthUnit;
using api::Span;

// A distance that is a limit. Exactly one of the two is given; neither: the gate has no such limit.
struct Limit {
  std::optional<double> max_distance;  // in `unit`; without a unit, in the unit of the result (docs/units.md)
  std::optional<double>
      max_diagonal_share;          // fraction of the diagonal of the baseline's bounding box: 0.01 is one percent
  std::optional<LengthUnit> unit;  // unit of max_distance

  bool is_given() const { return max_distance || max_diagonal_share; }
};

// The largest share of the area, from 0 to 1, that may be farther than a distance.
struct AreaLimit {
  Limit distance;
  double share = 0;
};

// A region, in the unit of the limits, and its limit, a length or a share as the gate's; not given: that of the gate.
struct RegionLimit {
  Region region;
  Limit limit;
};

// How far the candidate may be inside and outside of the baseline, in the same unit.
struct ZoneLimit {
  Limit inside;
  Limit outside;
};

// The engine's defaults, with a smaller tolerance: a gate ends when its limit is decided, and an interval of one
// percent could still contain the limit. Once it is decided the interval is narrowed, so that reports say by how much a
// gate passes or fails.
inline Options gate_options() {
  Options options;
  options.tolerance = {std::nullopt, 1e-9, std::nullopt};
  options.narrow = true;
  return options;
}

// A gate that limits the area or the sides alone needs no narrow interval of the distance, which is only shown.
inline constexpr Tolerance kToleranceOfArea{std::nullopt, 1e-3, 0.1};

// `candidate` is mesh a, `baseline` mesh b: a_to_b is from the candidate to the baseline.
struct Gate {
  std::string name;                 // unique in a run
  std::filesystem::path candidate;  // as a user would write it: relative to the current folder where possible
  std::filesystem::path baseline;
  std::shared_ptr<const api::Pipes> pipes;  // what was sent by those of the two that are pipes; null: both are files
  Limit limit;                              // max_distance
  std::optional<AreaLimit> area_limit;  // max_share_beyond; its distance has the unit of `limit`, where both are given
  std::vector<RegionLimit> regions;     // max_distance is the limit of the rest
  std::optional<ZoneLimit> zone;        // in the unit of the other limits
  Limit uncertainty;                    // of the distances, ISO 14253-1; in the unit of the limits
  // Holds direction, strategy, points, tolerance, threads and the declared units; options_of() adds the limits.
  api::ComparisonOptions options = gate_options();
  bool threads_given = false;                 // false: the run decides
  bool tolerance_given = false;               // false: kToleranceOfArea without max_distance
  std::chrono::milliseconds timeout{30'000};  // time limit of the whole gate
  bool warn_only = false;                     // fail and undecided are reported and do not count
  bool statistics = false;
  bool cloud = false;  // the candidate may be a point cloud; an XYZ always may
  Expectations expect;
  std::string manifest;  // manifest that contains the gate, for reports that point at a line; empty: given by flags
  int line = 0;          // 1-based
  std::vector<std::string> notes{};  // sentences of the manifest without full stop: files that a glob passes over
};

// The limits of a gate as numbers, lengths in the unit of the result. At least one is given.
struct Limits {
  std::optional<double> max_distance;
  std::optional<api::ShareLimit> max_share_beyond;
  std::optional<SideOptions::Zone> zone{};
  double uncertainty = 0;
  std::vector<Region> regions{};
};

// The distance that has the gate's unit.
inline const Limit& main_limit(const Gate& gate) {
  if (gate.limit.is_given()) return gate.limit;
  if (gate.area_limit) return gate.area_limit->distance;
  return gate.zone ? gate.zone->outside : gate.limit;
}

// Whether limits_of() needs the diagonal.
inline bool has_diagonal_share(const Gate& gate) { return main_limit(gate).max_diagonal_share.has_value(); }

// `baseline_diagonal`: diagonal of the baseline's bounding box, in the baseline's unit; a share is a fraction of it.
inline Limits limits_of(const Gate& gate, double baseline_diagonal) {
  const auto length = [&](const Limit& limit) {
    return limit.max_distance ? *limit.max_distance : limit.max_diagonal_share.value_or(0) * baseline_diagonal;
  };
  Limits limits;
  if (gate.limit.is_given()) limits.max_distance = length(gate.limit);
  if (gate.area_limit) limits.max_share_beyond = {length(gate.area_limit->distance), gate.area_limit->share};
  for (const RegionLimit& one : gate.regions) {
    Region& region = limits.regions.emplace_back(one.region);
    if (one.limit.is_given()) region.max_distance = length(one.limit);
  }
  if (gate.zone) limits.zone = {length(gate.zone->inside), length(gate.zone->outside)};
  limits.uncertainty = length(gate.uncertainty);
  return limits;
}

// Returns the options of the gate, for api::compare() or a service. Threads are those of the gate.
inline api::ComparisonOptions options_of(const Gate& gate, const Limits& limits) {
  api::ComparisonOptions options = gate.options;
  options.max_distance = limits.max_distance;
  options.max_share_beyond = limits.max_share_beyond;
  options.regions = limits.regions;
  options.zone = limits.zone;
  options.uncertainty = limits.uncertainty;
  options.units.limit = main_limit(gate).unit;
  options.units.limit_of_b = has_diagonal_share(gate);
  if (!limits.max_distance && !gate.tolerance_given) options.tolerance = kToleranceOfArea;
  if (gate.statistics) options.statistics.emplace();
  options.expect = gate.expect;
  return options;
}

}  // namespace meshgauge::check
