// Writes the result of a comparison, the same for HTTP and the command line.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

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

// Returns the result document (openapi.yaml, "Comparison"), with keys in a fixed order. It equals what is parsed of its
// text: NaN and infinity are null.
nlohmann::ordered_json document_of(const Comparison& comparison);

// Returns the document as compact text. Numbers round-trip.
std::string to_json(const Comparison& comparison);

}  // namespace meshgauge::api
