// Options of a comparison: the engine's options and the units of the lengths among them.
#pragma once

#include <optional>

#include "api/options/asked_units.h"
#include "api/options/expectations.h"
#include "engine/extras/align/align.h"
#include "engine/options.h"

namespace meshgauge::api {

// A limit of the area: at most `share`, from 0 to 1, may be farther than `distance` from the other mesh, in each
// direction that is measured.
struct ShareLimit {
  double distance = 0;
  double share = 0;

  bool operator==(const ShareLimit&) const = default;
};

// Engine options with units. max_distance, tolerance.absolute and the distances of areas are in the unit of the result
// (UnitPlan::result).
struct ComparisonOptions : Options {
  ComparisonOptions() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): the engine's options alone ask for no unit
  ComparisonOptions(const Options& engine, const AskedUnits& asked = {}) : Options(engine), units(asked) {}

  AskedUnits units;
  std::optional<AlignOptions> align;           // moves mesh a first, in the unit of the result; nullopt: as it is
  bool topology = false;                       // also examine both meshes (engine/mesh/topology.h)
  std::optional<ShareLimit> max_share_beyond;  // of the gate
  std::optional<SideOptions::Limits> zone;     // of the gate: limits inside and outside of mesh b
  Expectations expect;                         // of mesh a itself; they may need its topology
};

// Whether there is a gate.
bool has_limit(const ComparisonOptions& options);

}  // namespace meshgauge::api
