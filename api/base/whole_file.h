// Reads whole files into memory: the bytes of a mesh, and small texts, such as settings and manifests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "api/base/descriptor.h"
#include "engine/mesh/large_array.h"
#include "engine/result.h"

namespace meshgauge::api {

// A folder that files are opened below.
struct BaseFolder {
  std::string path;                                  // in messages
  std::shared_ptr<const Descriptor> held = nullptr;  // the folder, wherever the path leads by now; null: by the path
};

// Opens the folder `name`, which is as for WholeFile::open_below(); empty: the folder itself. Follows no symbolic link.
Result<Descriptor> open_folder_below(const BaseFolder& folder, const std::string& name);

// The content of a regular file. A directory, pipe or device is refused, since it has no size to check. The file is
// not mapped, because shortening a mapped file would end the process. A file whose size changes while it is read is
// an Error.
class WholeFile {
 public:
  static Result<WholeFile> open(const std::string& path);

  // Opens the file at the relative path `name` of plain components (api/formats/file/file_path.h) in `folder` or below.
  // Refuses symbolic links below the folder, '..', and more than `most` bytes. The path of the folder itself may have
  // links.
  static Result<WholeFile> open_below(const BaseFolder& folder, const std::string& name, std::uint64_t most);
  // Returns the size of a regular file which open_below() would open, and reads nothing.
  static Result<std::uint64_t> size_below(const BaseFolder& folder, const std::string& name);

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  static Result<WholeFile> read(int fd, const std::string& path, std::uint64_t most);
  explicit WholeFile(LargeArray<std::byte> bytes) : bytes_(std::move(bytes)) {}

  LargeArray<std::byte> bytes_;
};

// Returns the whole of a text file. Error: invalid_request when it cannot be read or has more than `max_bytes`; the
// message does not name the file.
Result<std::string> read_text_file(const std::string& file, std::size_t max_bytes);

}  // namespace meshgauge::api
