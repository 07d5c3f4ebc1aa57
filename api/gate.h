// The verdict of a gate: whether an interval is within a limit.
#pragma once

#include <optional>
#include <string_view>

#include "engine/outcome.h"

namespace meshgauge::api {

enum class Verdict { pass, fail, undecided };

std::string_view to_string(Verdict verdict);

// Returns pass when the distance is certainly at most max_distance (upper <= max_distance), fail when it is certainly
// above (lower > max_distance), undecided when max_distance lies inside the interval; nullopt: without max_distance.
std::optional<Verdict> verdict(const Outcome& outcome, const std::optional<double>& max_distance);

}  // namespace meshgauge::api
