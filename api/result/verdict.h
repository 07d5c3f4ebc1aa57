// Verdicts: whether what was certified is within a limit.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "api/options/comparison_options.h"
#include "api/options/names.h"
#include "engine/outcome.h"

namespace meshgauge::api {

enum class Verdict { pass, fail, undecided };

inline constexpr Name<Verdict> kVerdicts[] = {
    {Verdict::pass, "pass"}, {Verdict::fail, "fail"}, {Verdict::undecided, "undecided"}};

std::string_view to_string(Verdict verdict);
int severity(Verdict verdict);        // 0: pass, 1: undecided, 2: fail
Verdict worst(Verdict a, Verdict b);  // the one of greater severity

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

// Returns the share of the area that is farther than max_share_beyond's distance, in the direction where it is largest;
// with an uncertainty U, from the share beyond the distance plus U to that beyond the distance less U; from 0 to 1
// where the areas of a direction that was asked for are missing. nullopt: without max_share_beyond. The engine was
// asked for it by engine_options().
std::optional<AreaInterval> share_beyond(const Outcome& outcome, const ComparisonOptions& options);

}  // namespace meshgauge::api
