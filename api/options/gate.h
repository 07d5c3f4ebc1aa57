// The limits of a request: whether they fit each other, in which unit they are, and what they ask of the engine.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "api/options/comparison_options.h"

namespace meshgauge::api {

// Whether the uncertainty is above no limit of a distance, of a region's or of the area's: else nothing could pass.
bool uncertainty_fits(const ComparisonOptions& options);

// Replaces limits that are fractions of the diagonal of mesh b's bounding box by lengths in the unit of mesh b.
void resolve_shares(ComparisonOptions& options, double diagonal);

// Returns the engine's options, with the zone, and with the question that max_share_beyond asks of the areas at the end
// of theirs. With an uncertainty U it is two: of its distance less U, then plus U.
Options engine_options(const ComparisonOptions& options);

inline constexpr std::string_view kRest = "rest";  // the name of what is in no region

// Returns the limit of a region, or behind them of the rest; nullopt: none.
std::optional<double> limit_of_region(const ComparisonOptions& options, std::size_t region);

}  // namespace meshgauge::api
