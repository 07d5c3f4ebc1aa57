// Names that gates have in a manifest and as flags, beside those of the API (api/names.h).
#pragma once

#include "api/names.h"
#include "engine/options.h"

namespace meshgauge::check {

// By what they are to a gate, or as in the API: a is the candidate. The first name of a value is the one to show.
inline constexpr api::Name<Direction> kDirections[] = {{Direction::symmetric, "symmetric"},
                                                       {Direction::a_to_b, "candidate_to_baseline"},
                                                       {Direction::b_to_a, "baseline_to_candidate"},
                                                       {Direction::a_to_b, "a_to_b"},
                                                       {Direction::b_to_a, "b_to_a"}};

inline constexpr api::Name<bool> kOnFail[] = {{false, "fail"}, {true, "warn"}};                 // Gate::warn_only
inline constexpr api::Name<bool> kUnmatchedBaselines[] = {{false, "error"}, {true, "ignore"}};  // Draft

}  // namespace meshgauge::check
