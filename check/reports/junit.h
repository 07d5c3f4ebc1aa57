// The outcomes as JUnit XML, which every CI system reads: a test suite a gate, with one test. Valid by the schema of
// Ant's reports (windyroad's JUnit.xsd, the strictest) and by that of Jenkins, whatever a file's name holds.
#pragma once

#include <chrono>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// A gate that counts as failed is a <failure> of type fail or undecided, one that could not be measured an <error>;
// one that only warns has passed, and its <system-out> says so. The suite's properties hold the interval, the limit and
// the witness in all digits. `when` is what the schema asks for: the time of the run.
std::string to_junit(const Report& report,
                     std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

}  // namespace meshgauge::check
