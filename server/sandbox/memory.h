// What a reading asks for before it takes memory.
#pragma once

#include <cstdint>

#include "engine/result.h"

namespace meshgauge::server::sandbox {

// An Error ends the reading, and is its result. For the thread that reads.
class Memory {
 public:
  virtual ~Memory() = default;

  // For the process that reads, in place of all that was taken since end_reader(): an earlier process's attempt at the
  // same file has failed. Returns the limit of its memory, at most `bytes`.
  virtual Result<std::uint64_t> take_reader(std::uint64_t bytes) = 0;
  virtual void end_reader() = 0;  // the process has ended; its mesh stays
  // For the mesh, in this process, before its arrays come.
  virtual Result<Done> take_mesh(std::uint64_t vertices, std::uint64_t triangles) = 0;
};

}  // namespace meshgauge::server::sandbox
