// The verdict of a gate: whether what was certified is within its limits.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "api/options/comparison_options.h"
#include "engine/outcome.h"
#include "engine/result.h"

namespace meshgauge::api {

enum class Verdict { pass, fail, undecided };

std::string_view to_string(Verdict verdict);
Verdict worst(Verdict a, Verdict b);  // fail, else undecided, else pass

// Whether the uncertainty is above no limit of a distance, of a region's or of the area's: else nothing could pass.
bool uncertainty_fits(const ComparisonOptions& options);

// Replaces limits that are fractions of the diagonal of mesh b's bounding box by lengths in the unit of mesh b.
void resolve_shares(ComparisonOptions& options, double diagonal);

// Returns pass when what lies in [lower, upper] is certainly at most `limit` (upper <= limit - uncertainty), fail when
// it is certainly above (lower > limit + uncertainty), undecided when the limit lies inside the interval.
Verdict verdict_within(double lower, double upper, double limit, double uncertainty = 0);

// A limit of the distance, or of that on one side of the other mesh, and the interval of what it limits.
struct DistanceLimit {
  double limit = 0;
  double lower = 0;
  double upper = 0;
  std::string_view side{};  // "inside", "outside"; empty: both
};

// Returns the limit that distances without a sign are shown against. Of the limits with the worst verdict it is
//   1. the first that is of both sides;
//   2. else the smallest, or the largest where all pass.
// Precondition: there is a limit.
DistanceLimit shown_limit(std::span<const DistanceLimit> limits, double uncertainty);

// Returns the engine's options, with the zone, and with the question that max_share_beyond asks of the areas at the end
// of theirs. With an uncertainty U it is two: of its distance less U, then plus U.
Options engine_options(const ComparisonOptions& options);

// Returns the share of the area that is farther than max_share_beyond's distance, in the direction where it is largest;
// with an uncertainty U, from the share beyond the distance plus U to that beyond the distance less U; from 0 to 1
// where the areas of a direction that was asked for are missing. nullopt: without max_share_beyond.
std::optional<AreaInterval> share_beyond(const Outcome& outcome, const ComparisonOptions& options);

inline constexpr std::string_view kRest = "rest";  // the name of what is in no region

// Returns the limit of a region, or behind them of the rest; nullopt: none.
std::optional<double> limit_of_region(const ComparisonOptions& options, std::size_t region);

}  // namespace meshgauge::api
