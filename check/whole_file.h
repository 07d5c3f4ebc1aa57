// A file as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "engine/result.h"

namespace meshgauge::check {

// Reads a regular file into memory; anything else (a directory, a pipe, a device) is refused, since it has no size to
// check. It is not mapped: a file that another program shortens while it is looked at would end the process. One that
// changes its size while it is read is an Error.
class WholeFile {
 public:
  static Result<WholeFile> open(const std::string& path);

  // The same of a file in `folder` or below, at the relative path `name` of plain components (api/formats/file_path.h).
  // Refused: a symbolic link on the way from the folder or at its end, and more than `most` bytes. The way to the
  // folder itself may have links.
  static Result<WholeFile> open_below(const std::string& folder, const std::string& name, std::uint64_t most);

  std::span<const std::byte> bytes() const { return {bytes_.get(), size_}; }

 private:
  static Result<WholeFile> read(int fd, const std::string& path, std::uint64_t most);
  WholeFile(std::unique_ptr<std::byte[]> bytes, std::size_t size) : bytes_(std::move(bytes)), size_(size) {}

  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0;
};

}  // namespace meshgauge::check
