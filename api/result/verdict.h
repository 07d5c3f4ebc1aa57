// Verdicts: whether what was certified is within a limit.
#pragma once

#include <string_view>

#include "api/options/names.h"
#include "engine/options.h"

namespace meshgauge::api {

enum class Verdict { pass, fail, undecided };

inline constexpr Name<Verdict> kVerdicts[] = {
    {Verdict::pass, "pass"}, {Verdict::fail, "fail"}, {Verdict::undecided, "undecided"}};

std::string_view to_string(Verdict verdict);
int severity(Verdict verdict);        // 0: pass, 1: undecided, 2: fail
Verdict worst(Verdict a, Verdict b);  // the one of greater severity

// Returns pass when what lies in [lower, upper] is certainly within the limit (upper <= ends.pass), fail when it is
// certainly beyond (lower > ends.fail), undecided when neither holds.
Verdict verdict_within(double lower, double upper, const LimitEnds& ends);

}  // namespace meshgauge::api
