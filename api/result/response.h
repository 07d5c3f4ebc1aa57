// Writes the result of a comparison as JSON, the same for HTTP and the command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/compare/compare.h"
#include "api/options/expectations.h"
#include "api/options/gate.h"

namespace meshgauge::api {

// Returns compact JSON with keys in a fixed order. Numbers round-trip; NaN and infinity are null.
std::string to_json(const Comparison& comparison);

// Returns what the options expect of mesh a, and what was found. Empty: nothing is expected.
std::vector<Expectation> expectations_of(const Comparison& comparison);

struct Stage {
  const char* name;
  double ms;
};

inline constexpr const char* kStageNames[] = {"queue",  "read_a",  "read_b", "align",      "build", "traverse",
                                              "reduce", "certify", "areas",  "statistics", "total"};

// Returns the stages in the order of kStageNames; "align", "areas" and "statistics" only if they were requested.
std::vector<Stage> stages(const Comparison& comparison);

// Returns the stage times as the value of a Server-Timing header: "queue;dur=0.1, read_a;dur=12.3, ...".
std::string to_server_timing(const std::vector<Stage>& stages);
std::string to_server_timing(const Comparison& comparison);

}  // namespace meshgauge::api
