// A mesh that is ready to be compared, once or many times: read, prepared (engine/prepared.h), and known by its facts.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "api/formats/format.h"
#include "api/load.h"
#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/prepared.h"
#include "engine/result.h"
#include "engine/scaling.h"

namespace meshgauge::api {

// Of the file: lengths and coordinates are its own numbers.
struct MeshFacts {
  Format format = Format::obj;
  std::size_t bytes = 0;
  std::string sha256;  // of the bytes as sent, 64 lower-case hex digits
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t degenerate = 0;
  Box bbox;
  double diagonal = 0;
  ReadNotes notes;
};

// Immutable; any number of comparisons may use it at once.
struct PreparedMesh {
  // `file_bytes`: of the file that it was loaded from. Linear time. Must not be used when `interrupted` said to stop.
  PreparedMesh(LoadedMesh loaded, std::size_t file_bytes, Prepared::Use use,
               const Interrupted& interrupted = never_interrupted);

  std::size_t bytes() const { return sizeof *this - sizeof mesh + mesh.bytes(); }  // of memory, now

  const MeshFacts facts;
  const Prepared mesh;
};

// The mesh as it is measured: times a factor, which costs a copy of its positions unless the factor is one. Keeps
// `mesh` alive. An Error names `part` ("a", "b"): coordinate_too_large, or out_of_time when `control` said to stop.
Result<std::shared_ptr<const Prepared>> in_unit(const std::shared_ptr<const PreparedMesh>& mesh,
                                                const std::string& part, const Factor& factor, Control& control);

// How a comparison gets one of its meshes: an Error is as that of a Load. Called once, on the thread of the job.
using GetMesh = std::function<Result<std::shared_ptr<const PreparedMesh>>(Control& control)>;

// Has `load` get that file. Borrows all three.
GetMesh loading(const Load& load, const MeshInput& input, const ReadLimits& limits, Prepared::Use use);

}  // namespace meshgauge::api
