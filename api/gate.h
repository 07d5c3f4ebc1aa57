// The verdict of a gate: what an interval says about a limit.
#pragma once

#include <optional>
#include <string_view>

#include "engine/outcome.h"

namespace meshgauge::api {

enum class Verdict { pass, fail, undecided };

std::string_view to_string(Verdict verdict);

// pass: the distance is certainly at most max_distance (upper <= max_distance). fail: it is certainly above
// (lower > max_distance). undecided: max_distance lies inside the interval. nullopt: no gate was asked for.
std::optional<Verdict> verdict(const Outcome& outcome, const std::optional<double>& max_distance);

}  // namespace meshgauge::api
