// Files in memory, as which meshes pass between the server and its workers, and the seals that keep what has been
// checked from being changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "engine/mesh.h"
#include "server/sandbox/descriptor.h"

namespace meshgauge::server::sandbox {

// Empty and without a name, in memory. No file and errno when there is none to be had.
Descriptor memory_file();

// Nobody can write to it, shorten or lengthen it any more, this process included. False when the kernel knows no seals,
// or somebody has it mapped to be written to, or has sealed it against seals.
bool seal(int file);

bool seals_are_known();  // to this kernel

// A copy, sealed where seals are known. No file when memory ran out.
Descriptor sealed_copy(std::span<const std::byte> bytes);

// A worker's output. Precondition: the file cannot change any more.
class SharedMesh {
 public:
  // Null when the file has not exactly the size of these arrays, or cannot be mapped.
  static std::shared_ptr<const SharedMesh> map(int file, std::uint64_t vertices, std::uint64_t triangles);

  SharedMesh(const SharedMesh&) = delete;
  SharedMesh& operator=(const SharedMesh&) = delete;
  ~SharedMesh();

  MeshView view() const { return view_; }  // any numbers may be in it: validate()

 private:
  SharedMesh(void* start, std::size_t vertices, std::size_t triangles);

  void* start_;
  MeshView view_;
};

}  // namespace meshgauge::server::sandbox
