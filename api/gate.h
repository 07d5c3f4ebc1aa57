// The verdict of a gate: whether what was certified is within its limits.
#pragma once

#include <optional>
#include <string_view>

#include "api/comparison_options.h"
#include "engine/outcome.h"

namespace meshgauge::api {

enum class Verdict { pass, fail, undecided };

std::string_view to_string(Verdict verdict);

// Returns pass when what lies in [lower, upper] is certainly at most `limit` (upper <= limit), fail when it is
// certainly above (lower > limit), undecided when the limit lies inside the interval.
Verdict verdict_within(double lower, double upper, double limit);

// Returns the engine's options, with the question that max_share_beyond asks of the areas at the end of theirs.
Options engine_options(const ComparisonOptions& options);

// Returns the share of the area that is farther than max_share_beyond's distance, in the direction where it is largest;
// nullopt: without max_share_beyond.
std::optional<AreaInterval> share_beyond(const Outcome& outcome, const ComparisonOptions& options);

// Returns pass when every limit is kept, fail when one is certainly exceeded; nullopt: without a limit.
std::optional<Verdict> verdict(const Outcome& outcome, const ComparisonOptions& options);

}  // namespace meshgauge::api
