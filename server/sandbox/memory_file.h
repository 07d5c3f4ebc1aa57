// Unnamed files in memory, shared by the server and its workers, and seals that fix their content.
#pragma once

#include <cstddef>
#include <span>

#include "server/sandbox/descriptor.h"

namespace meshgauge::server::sandbox {

bool seals_are_known();  // whether this kernel supports them

// Returns a read-only copy, sealed where seals are supported. No file: memory ran out.
Descriptor sealed_copy(std::span<const std::byte> bytes);

// Returns an executable copy of a program. No file, with errno: memory ran out, or this machine does not execute such
// files.
Descriptor executable_copy(std::span<const std::byte> bytes);

// A writable file of zeros. `fixed`: its size is sealed, so mapping it is safe.
struct SizedFile {
  Descriptor file;
  bool fixed = false;
};
SizedFile file_of_size(std::size_t bytes);  // no file: memory ran out

}  // namespace meshgauge::server::sandbox
