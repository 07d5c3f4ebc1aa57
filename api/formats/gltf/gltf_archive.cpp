#include "api/formats/gltf/gltf_archive.h"

#include <string_view>
#include <utility>

#include "api/formats/file/readers.h"
#include "api/formats/gltf/gltf_bundle.h"

namespace meshgauge::api {
namespace {

// Returns the names of all .gltf files, in lower case. Skips __macosx/: macOS adds a file of attributes there for each
// file, with the same suffix.
std::vector<std::string> scenes_in(const ZipArchive& archive) {
  std::vector<std::string> scenes;
  for (std::string& name : archive.names()) {
    if (is_scene_path(name) && !name.starts_with("__macosx/")) scenes.push_back(std::move(name));
  }
  return scenes;
}

std::string folder_of(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? "" : name.substr(0, slash + 1);
}

}  // namespace

bool holds_gltf(std::span<const std::byte> bytes) {
  const ReadLimits limits;
  const Source source{bytes, "", limits};
  const auto archive = ZipArchive::open(source);
  return archive && !archive->has(kRelationships) && !scenes_in(*archive).empty();
}

Result<GltfArchive> GltfArchive::open(const Source& source) {
  auto archive = ZipArchive::open(source);
  if (!archive) return std::move(archive).error();
  const auto scenes = scenes_in(*archive);
  if (scenes.size() != 1) {
    return about(source.part, ErrorCode::unreadable_mesh,
                 "is a zip archive with " + std::to_string(scenes.size()) + " .gltf files; exactly one is allowed");
  }
  GltfArchive opened(std::move(*archive));
  opened.folder_ = folder_of(scenes.front());
  auto scene = opened.expanded(scenes.front());
  if (!scene) return std::move(scene).error();
  opened.scene_ = std::move(*scene);
  return opened;
}

Result<std::vector<char>> GltfArchive::expanded(const std::string& name) {
  std::vector<char> bytes;
  bytes.reserve(archive_.announced_bytes(name));  // if the size is false, untouched pages take no memory
  const auto ok = archive_.read(name, [&](std::string_view piece) {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return std::optional<Error>();
  });
  if (!ok) return ok.error();
  return bytes;
}

Result<std::optional<std::span<const std::byte>>> GltfArchive::file(const std::string& path) {
  const std::string name = folder_ + path;
  auto found = files_.find(name);
  if (found == files_.end()) {
    if (!archive_.has(name)) return std::optional<std::span<const std::byte>>();
    auto bytes = expanded(name);
    if (!bytes) return std::move(bytes).error();
    found = files_.emplace(name, std::move(*bytes)).first;
  }
  return std::optional(std::as_bytes(std::span(std::as_const(found->second))));
}

}  // namespace meshgauge::api
