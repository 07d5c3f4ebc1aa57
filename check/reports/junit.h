// Writes outcomes as JUnit XML: a test suite with one test for each gate. Valid by the schema of Ant's reports
// (windyroad's JUnit.xsd, the strictest) and by that of Jenkins, for any file name.
#pragma once

#include <chrono>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// A gate that counts as failed is a <failure> of type fail or undecided; one that could not be measured is an
// <error>; one that only warns has passed, and its <system-out> says so. The suite's properties hold the interval,
// the limit and the witness with all digits. `when`: time of the run, which the schema requires.
std::string to_junit(const Report& report,
                     std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

}  // namespace meshgauge::check
