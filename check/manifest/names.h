// Names of values in a manifest and in flags, beside those of the API (api/names.h).
#pragma once

#include "api/names.h"
#include "engine/options.h"

namespace meshgauge::check {

// In gates a is the candidate; the names of the API are accepted as well. The first name of a value is shown.
inline constexpr api::Name<Direction> kDirections[] = {{Direction::symmetric, "symmetric"},
                                                       {Direction::a_to_b, "candidate_to_baseline"},
                                                       {Direction::b_to_a, "baseline_to_candidate"},
                                                       {Direction::a_to_b, "a_to_b"},
                                                       {Direction::b_to_a, "b_to_a"}};

inline constexpr api::Name<bool> kOnFail[] = {{false, "fail"}, {true, "warn"}};  // values of Gate::warn_only
inline constexpr api::Name<bool> kUnmatchedBaselines[] = {{false, "error"},
                                                          {true, "ignore"}};  // values of Draft::unmatched_ignored

}  // namespace meshgauge::check
