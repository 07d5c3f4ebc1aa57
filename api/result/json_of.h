// Converts pieces of a result to JSON.
#pragma once

#include <optional>
#include <string>

#include "api/compare/compare.h"
#include "api/options/write_options.h"
#include "engine/area.h"
#include "engine/outcome.h"
#include "engine/sides.h"

namespace meshgauge::api {

Json interval(double lower, double upper);
Json json_of(const Bounds& bounds);
Json json_of(const std::optional<Directed>& directed);
Json json_of(const KnownUnit& known);
Json json_of(const MeshFacts& facts, const KnownUnit& unit);
Json json_of(const std::optional<Topology>& topology);
Json meshes_of(const Comparison& comparison);  // facts of both, with the topology where it was asked for

// What was measured of the regions, in the order of Outcome::regions.
Json regions_of(const Outcome& outcome, const ComparisonOptions& options);

Json json_of(const AreaOutcome& areas);
Json json_of(const SideOutcome& sides, const std::optional<LengthUnit>& unit);
// Returns "mesh b is open: an edge at (0.5, 0, 1) mm has one triangle" or the like.
std::string in_words(const NoSides& refused, const std::optional<LengthUnit>& unit);

}  // namespace meshgauge::api
