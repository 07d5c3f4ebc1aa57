// The limits of a request: whether they fit each other, in which unit they are, and what they ask of the engine.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "api/options/comparison_options.h"

namespace meshgauge::api {

// Whether something could pass: no limit of a distance has an end below 0 (Options::ends()).
bool uncertainty_fits(ComparisonOptions options);

// Returns the name of the option that has a length in the unit of the limits: the first one that is not 0, or else that
// is set; empty: there is none.
std::string_view first_length(ComparisonOptions options);

// Replaces limits that are fractions of the diagonal of mesh b's bounding box by lengths in the unit of mesh b; NaN: of
// a diagonal that is not known.
void resolve_shares(ComparisonOptions& options, double diagonal);

// Returns the engine's options, with what the limits ask of the sides, and of the areas, at the end of their questions.
// A limited share is that beyond one distance, or beyond the ends of it, the nearer first.
Options engine_options(const ComparisonOptions& options);

inline constexpr std::string_view kRest = "rest";  // the name of what is in no region

// Returns the limit of a region, or behind them of the rest; nullopt: none.
std::optional<double> limit_of_region(const ComparisonOptions& options, std::size_t region);

}  // namespace meshgauge::api
