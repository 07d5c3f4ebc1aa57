// The result of a comparison as JSON: the same bytes from HTTP and from the command line.
#pragma once

#include <string>
#include <vector>

#include "api/compare.h"

namespace meshgauge::api {

// Compact, keys in a fixed order. Numbers round-trip; what is not finite is null.
std::string to_json(const Comparison& comparison);

struct Stage {
  const char* name;
  double ms;
};

inline constexpr const char* kStageNames[] = {"queue",  "read_a",  "read_b",     "build", "traverse",
                                              "reduce", "certify", "statistics", "total"};

// The stages in their order, and "total" at the end; "statistics" before it where there are some.
std::vector<Stage> stages(const Comparison& comparison);

// The stage times as the value of a Server-Timing header: "queue;dur=0.1, read_a;dur=12.3, ...".
std::string to_server_timing(const std::vector<Stage>& stages);
std::string to_server_timing(const Comparison& comparison);

}  // namespace meshgauge::api
