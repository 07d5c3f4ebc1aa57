// Options of a comparison: the engine's options and the units of the lengths among them.
#pragma once

#include "api/unit_plan.h"
#include "engine/options.h"

namespace meshgauge::api {

// Engine options with units. max_distance and tolerance.absolute are in the unit of the result (UnitPlan::result).
struct ComparisonOptions : Options {
  ComparisonOptions() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): the engine's options alone ask for no unit
  ComparisonOptions(const Options& engine, const AskedUnits& asked = {}) : Options(engine), units(asked) {}

  AskedUnits units;
  bool topology = false;  // also examine both meshes (engine/topology.h)
};

}  // namespace meshgauge::api
