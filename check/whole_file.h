// A file as bytes, without copying it.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "engine/result.h"

namespace meshgauge::check {

// Maps a regular file read-only; anything else (a directory, a pipe, a device) is refused, since it has no
// size to check. The bytes live as long as the object. A file that another program shortens meanwhile ends the process.
class MappedFile {
 public:
  static Result<MappedFile> open(const std::string& path);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::span<const std::byte> bytes_;
};

}  // namespace meshgauge::check
