// An earlier run, as its report by `check --json` tells, and what changed since.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "check/outcome.h"

namespace meshgauge::check {

// Reads a report that `check --json` wrote. One that cannot be read, as of another version, is Earlier::problem: it
// changes no verdict of this run.
Earlier earlier_run(const std::filesystem::path& report);

// A gate that is not as it was.
struct Change {
  std::string gate;    // its name, any bytes
  std::string before;  // "pass, 0.001 .. 0.0123 mm"; empty: the gate is new
  std::string now;     // empty: the gate is gone
};

// Returns the gates with another verdict or with a limit whose value certainly moved, by more than a hundredth of the
// limit, and those that one of the runs lacks: in the order of the gates, the ones that are gone at the end.
std::vector<Change> changes_since(const Earlier& earlier, const Report& report);

}  // namespace meshgauge::check
