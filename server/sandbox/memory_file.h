// Files without a name, in memory, that pass between the server and its workers, and seals that keep them as they are.
#pragma once

#include <cstddef>
#include <span>

#include "server/sandbox/descriptor.h"

namespace meshgauge::server::sandbox {

bool seals_are_known();  // to this kernel

// A copy that nobody can change, where seals are known. No file when memory ran out.
Descriptor sealed_copy(std::span<const std::byte> bytes);

// The same, of a program. No file, and errno, when memory ran out or this machine executes no such files.
Descriptor executable_copy(std::span<const std::byte> bytes);

// Zeros, to be written to. `fixed` tells whether its size is sealed: then it can be mapped without fear.
struct SizedFile {
  Descriptor file;
  bool fixed = false;
};
SizedFile file_of_size(std::size_t bytes);  // no file when memory ran out

}  // namespace meshgauge::server::sandbox
