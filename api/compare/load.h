// Loads a mesh file: reads it, welds it and computes its digest. The command line does so in its own process, the
// service in a sandbox (server/sandbox).
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "api/formats/format.h"
#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

struct MeshInput {
  std::string part;                  // "a" or "b": names the input in messages
  std::span<const std::byte> bytes;  // borrowed for the duration of a call
  std::string filename;              // hint for the format, may be empty
  std::string media_type;            // hint for the format, may be empty
  int file = -1;                     // borrowed descriptor of the same bytes, for a reader in another process; -1: none
  std::string sha256 = {};           // of a file that was stored with this digest; empty: not known
};

struct LoadedMesh {
  MeshView mesh;  // passes validate() within the limits
  Format format = Format::obj;
  ReadNotes notes;
  std::string sha256;                  // digest of the bytes as sent, 64 lower-case hex digits; empty for arrays
  std::shared_ptr<const void> arrays;  // owns the arrays that `mesh` borrows
  Groups groups = {};
};

// Loads in this process, in time linear in the bytes. Errors: as for read_mesh(). Thread safe.
Result<LoadedMesh> load(const MeshInput& input, const ReadLimits& limits);

// Returns the out_of_time error of a job interrupted before `what`, for example "'a' was read".
Error not_in_time(Interruption why, const std::string& what);
// Returns not_in_time() when `control` says to stop, else Done.
Result<Done> in_time(Control& control, const std::string& what);

}  // namespace meshgauge::api
