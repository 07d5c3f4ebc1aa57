// A mesh file on its way into the engine: read, welded and named by its digest. The command line has it done here, the
// service in a process apart (server/sandbox).
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
  std::span<const std::byte> bytes;  // must outlive the call it is given to
  std::string filename;              // hint for the format, may be empty
  std::string media_type;            // hint for the format, may be empty
  int file = -1;  // a descriptor of the same bytes for a reader in another process, borrowed; -1: there is none
};

struct LoadedMesh {
  MeshView mesh;  // passes validate() within the limits
  Format format = Format::obj;
  ReadNotes notes;
  std::string sha256;                  // of the bytes as sent, 64 lower-case hex digits
  std::shared_ptr<const void> arrays;  // what `mesh` borrows from
};

// Reads in this process, in time linear in the bytes. An Error is about the input. Thread safe.
Result<LoadedMesh> load(const MeshInput& input, const ReadLimits& limits);

// The error of a job that was interrupted before it had done `what`: "'a' was read".
Error not_in_time(Interruption why, const std::string& what);
// That error if `control` says to stop.
Result<Done> in_time(Control& control, const std::string& what);

}  // namespace meshgauge::api
