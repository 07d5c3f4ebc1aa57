// A glTF of several files in a zip archive: exactly one .gltf, and the files that its buffers name relative to its
// folder.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/formats/file/zip.h"

namespace meshgauge::api {

// Returns true when the bytes are a zip archive that holds a .gltf and is not a package (3MF). Throws std::bad_alloc.
bool holds_gltf(std::span<const std::byte> bytes);

class GltfArchive {
 public:
  // Opens the archive and expands the .gltf; borrows `source`. Errors: as for ZipArchive; more than one .gltf.
  static Result<GltfArchive> open(const Source& source);

  std::span<const std::byte> scene() const { return std::as_bytes(std::span(scene_)); }

  // Returns the expanded bytes of the entry at `path` relative to the folder of the .gltf; nullopt: no such entry. Each
  // entry is expanded once, all of them within expansion_limit(). The bytes live as long as this object.
  Result<std::optional<std::span<const std::byte>>> file(const std::string& path);

 private:
  explicit GltfArchive(ZipArchive archive) : archive_(std::move(archive)) {}
  Result<std::vector<char>> expanded(const std::string& name);

  ZipArchive archive_;
  std::string folder_;  // folder of the .gltf: empty, or ends with '/'
  std::vector<char> scene_;
  std::map<std::string, std::vector<char>> files_;  // key: name of the entry
};

}  // namespace meshgauge::api
