// The whole path of one comparison, without sockets or threads: two files as bytes in, the outcome out.
// HTTP and the command line both go through here, so that they give the same JSON.
//
//   load x2 (api/load.h: read_mesh, weld, digest) -> prepare x2 -> one unit (api/unit_plan.h) -> measure -> Comparison
//   (-> to_json, api/response.h)
#pragma once

#include <string>

#include "api/comparison_options.h"
#include "api/formats/format.h"
#include "api/load.h"
#include "api/prepared_mesh.h"
#include "engine/outcome.h"
#include "engine/result.h"

namespace meshgauge::api {

struct StageTimes {  // milliseconds of wall time; the engine's own stages are in Outcome::timings
  double queue = 0;
  double read_a = 0;
  double read_b = 0;
  double total = 0;
};

struct Comparison {
  std::string id;             // unguessable, 32 hex digits
  ComparisonOptions options;  // as run
  Outcome outcome;            // lengths and points in the unit of the result
  MeshFacts a;                // lengths in the file's own numbers
  MeshFacts b;
  UnitPlan units;
  StageTimes times;
};

// Both meshes are at hand. `so_far`: what was done before, counted into the total. `control` carries the deadline and
// the cancellation of the whole job; running out of time is an Outcome. An Error is about the input. Thread safe.
Result<Comparison> compare(const SharedMesh& a, const SharedMesh& b, const ComparisonOptions& options, Control& control,
                           const StageTimes& so_far = {});

// Reads both in this process first; running out of time meanwhile is an Error.
Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const ComparisonOptions& options,
                           const ReadLimits& limits, Control& control);

}  // namespace meshgauge::api
