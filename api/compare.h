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
#include "engine/hausdorff.h"
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

// `control` carries the deadline and the cancellation of the whole job, reading included. An Error is
// about the input; running out of time while measuring is an Outcome. Thread safe.
Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const ComparisonOptions& options,
                           const ReadLimits& limits, Control& control);

// The same with meshes that `load` gets, instead of api::load().
Result<Comparison> compare_by(const Load& load, const MeshInput& a, const MeshInput& b,
                              const ComparisonOptions& options, const ReadLimits& limits, Control& control);

// The same with meshes that may have been loaded, measured and kept before; then read_a and read_b are next to nothing,
// and so is the engine's build.
Result<Comparison> compare_prepared(const GetMesh& a, const GetMesh& b, const ComparisonOptions& options,
                                    Control& control);

}  // namespace meshgauge::api
