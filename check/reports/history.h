// The results of earlier runs: the file of `check --history`, JSON lines, one a gate and run.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "check/outcome.h"
#include "engine/result.h"

namespace meshgauge::check {

class History {
 public:
  // Reads the file; one that does not exist is made by keep(). Errors: invalid_request, naming --history and the line,
  // when it cannot be read or has a line that is no result of a gate.
  static Result<History> open(const std::filesystem::path& file);

  // Appends the report's gates to the file, and adds to each outcome its last 30 results, this one at the end. `time`:
  // RFC 3339. `commit`: the version that was measured; empty: not known. Errors: the file cannot be written.
  Result<Done> keep(const std::string& time, const std::string& commit, Report& report);

 private:
  std::filesystem::path file_;
  std::map<std::string, std::vector<PastRun>, std::less<>> runs_;  // by the name of the gate, the newest at the end
};

// Commit, verdict, bounds, null where not known, limit and unit; without the terms and the criteria.
nlohmann::ordered_json json_of(const PastRun& run);
// Name, lower and upper bound, null where not known, and limit of each.
nlohmann::ordered_json json_of(const std::map<std::string, PastCriterion>& criteria);

// Returns what a pipeline says it measures: MESHGAUGE_COMMIT, GITHUB_SHA, CI_COMMIT_SHA or GIT_COMMIT, the first of
// these variables that is set; else empty.
std::string commit_of_pipeline();

// The runs of one limit.
struct Chart {
  std::string what;  // "the distance", "the area farther than 0.05 mm"
  std::string unit;
  std::vector<PastRun> runs;  // an area in percent
};

// Returns a chart for each limit of the gate; none without --history.
std::vector<Chart> charts_of(const GateOutcome& outcome);

// " ± 0.01 mm" of the newest run; empty where there is none. Precondition: there is a run.
std::string margin_of(const Chart& chart);

// Draws the runs as one letter each, taller for a larger upper bound; the limit is the height of "▅". Empty for fewer
// than two runs.
std::string sparkline(const std::vector<PastRun>& runs);

}  // namespace meshgauge::check
