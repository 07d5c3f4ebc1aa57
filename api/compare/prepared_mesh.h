// A mesh ready to be compared, once or many times: loaded, prepared (engine/tree/prepared.h), with the facts of its
// file.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/compare/load.h"
#include "api/formats/format.h"
#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/scaling.h"
#include "engine/mesh/topology.h"
#include "engine/result.h"
#include "engine/tree/lazy.h"
#include "engine/tree/prepared.h"

namespace meshgauge::api {

// Facts of a mesh file. Lengths and coordinates are in the file's unit.
struct MeshFacts {
  Format format = Format::obj;
  std::size_t bytes = 0;
  std::string sha256;  // digest of the bytes as sent, 64 lower-case hex digits; empty for arrays
  std::size_t vertices = 0;
  std::size_t triangles = 0;  // 0: a point cloud
  std::size_t degenerate = 0;
  Box bbox;
  double diagonal = 0;
  ReadNotes notes;
  std::optional<Topology> topology;  // in the unit of a result; nullopt: not asked for, or interrupted
};

// A prepared mesh file. Logically immutable and thread safe: any number of comparisons may share it.
class PreparedMesh {
 public:
  // Computes the facts, in linear time. `file_bytes`: size of the file, or of the arrays. When `interrupted` said to
  // stop, the facts are incomplete and the object must not be used.
  PreparedMesh(LoadedMesh loaded, std::size_t file_bytes, Prepared::Use use,
               const Interrupted& interrupted = never_interrupted);

  std::size_t bytes() const;  // memory used now
  // In the file's unit. Examined by the first call that is not interrupted, and kept. nullopt: interrupted. Thread
  // safe.
  std::optional<Topology> topology(const Interrupted& interrupted) const;

  const MeshFacts facts;
  const Groups groups;
  const Prepared mesh;

 private:
  friend Result<std::shared_ptr<const Prepared>> in_unit(const std::shared_ptr<const PreparedMesh>&, const std::string&,
                                                         const Factor&, Control&);
  // The mesh with its positions times a factor. Borrows the triangles.
  struct Image {
    const Factor factor;
    const std::vector<Vec3> positions;
    const Prepared mesh;

    Image(const Prepared& of, const Factor& its_factor, RoundedImage scaled);
  };
  std::shared_ptr<const Image> image(const Factor& factor) const;  // nullptr: not cached for this factor

  mutable Lazy<Topology> topology_;
  mutable std::mutex mutex_;                    // guards image_
  mutable std::shared_ptr<const Image> image_;  // the last image, cached for Prepared::Use::often
};

using SharedMesh = std::shared_ptr<const PreparedMesh>;

// Returns the mesh with its positions times `factor`; the result keeps `mesh` alive. A factor other than 1 costs a copy
// of the positions, which a mesh of Use::often caches. Errors, with the part `part` ("a", "b"): coordinate_too_large;
// out_of_time when `control` says to stop. Thread safe.
Result<std::shared_ptr<const Prepared>> in_unit(const SharedMesh& mesh, const std::string& part, const Factor& factor,
                                                Control& control);

// Prepares the mesh loaded from `input`. Errors: that of `loaded`; out_of_time when `control` says to stop.
Result<SharedMesh> prepare(Result<LoadedMesh> loaded, const MeshInput& input, Prepared::Use use, Control& control);

}  // namespace meshgauge::api
