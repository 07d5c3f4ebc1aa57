// Writes the result of a comparison, the same for HTTP and the command line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/compare/compare.h"

namespace meshgauge::api {

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

// What is stored and sent of a result.
struct WrittenResult {
  std::string document;      // compact JSON, keys in a fixed order. Numbers round-trip; NaN and infinity are null
  std::string_view verdict;  // the worst of the criteria: "pass", "fail", "undecided"; empty: there is no criterion
  std::vector<Stage> stages;
  std::string timing;  // to_server_timing()
};

WrittenResult written(const Comparison& comparison);

// Returns the document alone.
std::string to_json(const Comparison& comparison);

}  // namespace meshgauge::api
