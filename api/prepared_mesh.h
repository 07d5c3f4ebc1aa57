// A mesh that is ready to be compared, once or many times: read, prepared (engine/prepared.h), and known by its facts.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

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

// Immutable as far as can be seen; any number of comparisons may use it at once.
class PreparedMesh {
 public:
  // `file_bytes`: of the file that it was loaded from. Linear time. Must not be used when `interrupted` said to stop.
  PreparedMesh(LoadedMesh loaded, std::size_t file_bytes, Prepared::Use use,
               const Interrupted& interrupted = never_interrupted);

  std::size_t bytes() const;  // of memory, now

  const MeshFacts facts;
  const Prepared mesh;

 private:
  friend Result<std::shared_ptr<const Prepared>> in_unit(const std::shared_ptr<const PreparedMesh>&, const std::string&,
                                                         const Factor&, Control&);
  // The mesh times a factor. Borrows the triangles.
  struct Image {
    const Factor factor;
    const std::vector<Vec3> positions;
    const Prepared mesh;

    Image(const Prepared& of, const Factor& its_factor, Scaled scaled);
  };
  std::shared_ptr<const Image> image(const Factor& factor) const;  // null: none of this factor is kept

  mutable std::mutex mutex_;                    // guards what follows
  mutable std::shared_ptr<const Image> image_;  // the last one made, of a mesh that is measured often
};

using SharedMesh = std::shared_ptr<const PreparedMesh>;

// The mesh as it is measured: times a factor. Unless that is one, this costs a copy of the positions, which a mesh that
// is measured often keeps for the next time. Keeps `mesh` alive. An Error names `part` ("a", "b"):
// coordinate_too_large, or out_of_time when `control` said to stop. Thread safe.
Result<std::shared_ptr<const Prepared>> in_unit(const SharedMesh& mesh, const std::string& part, const Factor& factor,
                                                Control& control);

// What was loaded of `input`, ready to be compared. An Error is that of `loaded`, or out_of_time when `control` said to
// stop.
Result<SharedMesh> prepare(Result<LoadedMesh> loaded, const MeshInput& input, Prepared::Use use, Control& control);

}  // namespace meshgauge::api
