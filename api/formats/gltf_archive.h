// A glTF of several files in a zip archive: exactly one .gltf, and what its buffers name relative to its folder.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/formats/zip.h"

namespace meshgauge::api {

// True when the bytes are a zip archive that holds a .gltf and is no package (3MF). May throw: out of memory.
bool holds_gltf(std::span<const std::byte> bytes);

class GltfArchive {
 public:
  // Expands the .gltf; `source` is borrowed. Refused: what ZipArchive refuses, more than one .gltf.
  static Result<GltfArchive> open(const Source& source);

  std::span<const std::byte> scene() const { return std::as_bytes(std::span(scene_)); }

  // The expanded bytes of the entry at `path` from the folder of the .gltf; nullopt: there is none. Each entry is
  // expanded once, all of them within expansion_limit(). The bytes live as long as this object.
  Result<std::optional<std::span<const std::byte>>> file(const std::string& path);

 private:
  explicit GltfArchive(ZipArchive archive) : archive_(std::move(archive)) {}
  Result<std::vector<char>> expanded(const std::string& name);

  ZipArchive archive_;
  std::string folder_;  // of the .gltf: empty, or with '/' at its end
  std::vector<char> scene_;
  std::map<std::string, std::vector<char>> files_;  // by name
};

}  // namespace meshgauge::api
