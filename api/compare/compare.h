// The whole path of one comparison, without sockets, from the bytes of two files to the outcome. HTTP and the command
// line both call it, so that they give the same JSON.
//
//   read_both {load (api/compare/load.h: read_mesh, weld, digest) -> prepare} -> one unit (api/compare/unit_plan.h) ->
//   align, move (api/compare/align.h) -> measure -> Comparison
//   (-> document_of, api/result/response.h)
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/compare/align.h"
#include "api/compare/load.h"
#include "api/compare/prepared_mesh.h"
#include "api/compare/unit_plan.h"
#include "api/formats/format.h"
#include "api/options/comparison_options.h"
#include "engine/control.h"
#include "engine/mesh/rigid.h"
#include "engine/outcome.h"
#include "engine/result.h"

namespace meshgauge::api {

struct StageTimes {  // milliseconds of wall time; the engine's own stages are in Outcome::timings
  double queue = 0;
  double read_a = 0;  // until a was read
  double read_b = 0;  // from then until b was read; so stages add up, also when both files are read side by side
  double total = 0;
  double align = 0;  // only with ComparisonOptions::align
};

struct Comparison {
  std::string id;                    // random, 32 hex digits (random_id())
  ComparisonOptions options;         // as applied
  Outcome outcome;                   // lengths and points in the unit of the result
  std::optional<Aligned> alignment;  // nullopt: not asked for
  MeshFacts a;                       // lengths in the file's unit
  MeshFacts b;
  UnitPlan units;
  StageTimes times;
};

// Compares two prepared meshes. `so_far`: stage times before this call; they count into the total. `control` carries
// the deadline and the cancellation of the whole job. Running out of time while measuring is an Outcome
// (Stop::timeout). Errors: empty_mesh when a direction would measure to a point cloud; contradicting units; out_of_time
// while a mesh is converted to the result's unit or aligned; internal when out of memory. Thread safe.
Result<Comparison> compare(const SharedMesh& a, const SharedMesh& b, const ComparisonOptions& options, Control& control,
                           const StageTimes& so_far = {});

// A part of the message that refuses to measure to a point cloud; `meshgauge check` chooses its advice by it.
inline constexpr std::string_view kAskFor = "ask for the direction";

struct SharedMeshes {
  SharedMesh a;
  SharedMesh b;
};

// A smaller file is read in less time than a second thread takes to begin and end.
inline constexpr std::uint64_t kLeastBytesBeside = std::uint64_t{1} << 16;

// Whether a comparison with so many threads reads its two files side by side. `bytes`: of the smaller one, if known.
constexpr bool reads_side_by_side(unsigned threads, std::uint64_t bytes = kLeastBytesBeside) {
  return threads > 1 && bytes >= kLeastBytesBeside;
}

// Reads one mesh, and stops when `control` says so. `beside`: the other mesh may be read at the same time. nullopt: for
// want of memory, or of another means, that the reading alone may have; only with `beside`. std::bad_alloc says the
// same.
using MeshReader = std::function<std::optional<Result<SharedMesh>>(bool beside, Control& control)>;

// Returns a MeshReader for files that this process reads. `read` reads the mesh.
MeshReader reader_here(std::function<Result<SharedMesh>(Control&)> read);

// Reads both meshes: `side_by_side`, or b after a. Meshes and Errors are the same either
// way, but for limits on memory: that of a, else that of b. A mesh that cannot be read beside the other is read again
// alone. A refused a stops b's reader, if that looks at its Control, and waits for it. Either may be called on another
// thread. An empty `read_b`: b is the same file as a. Notes read_a and read_b in `times`. Throws what a reader throws,
// when both have ended.
Result<SharedMeshes> read_both(const MeshReader& read_a, const MeshReader& read_b, bool side_by_side, Control& control,
                               StageTimes& times);

// Reads and prepares both files in this process, then compares them. Two inputs of the same name and bytes are read
// once. `meshes`, unless null, receives what was read; it may borrow the files. Errors also: the input is refused, or
// out_of_time while reading.
Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const ComparisonOptions& options,
                           const ReadLimits& limits, Control& control, SharedMeshes* meshes = nullptr);

// Both meshes of a comparison in the unit of its result.
struct MeasuredPair {
  std::shared_ptr<const Prepared> a;
  std::shared_ptr<const Prepared> b;
};

// Converts both meshes to the unit of the result and moves `a` by the motion of its alignment; nullopt: none. Errors:
// as for in_unit() and moved().
Result<MeasuredPair> in_unit_of_result(const SharedMesh& a, const SharedMesh& b, const UnitPlan& units,
                                       const std::optional<RigidMotion>& motion, Control& control);

}  // namespace meshgauge::api
