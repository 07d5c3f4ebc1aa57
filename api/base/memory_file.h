// Unnamed files in memory, and seals that fix their content: shared by the server and its workers, and for the mesh
// that a pipe sends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "api/base/descriptor.h"

namespace meshgauge {

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

// The bytes of a stream in a sealed file that is mapped, so that they take memory once.
class MemoryFile {
 public:
  MemoryFile(MemoryFile&& other) noexcept
      : start_(std::exchange(other.start_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  MemoryFile& operator=(MemoryFile&& other) noexcept {
    std::swap(start_, other.start_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~MemoryFile();

  enum class End { whole, too_large, no_memory, not_readable };  // not_readable, with errno: read() failed

  // Reads `from` to its end and puts the bytes into `to`. Blocks for as long as the writer does. too_large: more than
  // `most` bytes came.
  static End read_all(int from, std::uint64_t most, MemoryFile& to);

  MemoryFile() = default;

  std::span<const std::byte> bytes() const { return {start_, size_}; }

 private:
  MemoryFile(const std::byte* start, std::size_t size) : start_(start), size_(size) {}

  const std::byte* start_ = nullptr;  // null: no bytes
  std::size_t size_ = 0;
};

}  // namespace meshgauge
