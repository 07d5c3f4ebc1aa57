// A glTF of several files as one: a zip archive of the .gltf and the files that its buffers name. What is behind the
// intake (digest, store, caches, sandbox, batches) sees these bytes alone. The same files give the same bytes, wherever
// they are put together (docs/formats.md has the layout; server/web/page/form/bundle.ts makes it in the browser).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/file_path.h"
#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::string_view kBundleScene = "scene.gltf";  // the .gltf's name in the archive
inline constexpr std::size_t kMostBundleFiles = 64;             // beside the .gltf
inline constexpr std::uint64_t kMostBundleBytes = (std::uint64_t{1} << 32U) - 1;

// True when the bytes begin as the JSON of a .gltf does.
bool is_gltf_json(std::span<const std::byte> bytes);

// True when a file of this path would be taken for a .gltf: an archive has exactly one.
bool is_scene_path(std::string_view path);

// The paths of the files that the buffers of a .gltf name, sorted, each once. Empty too where the document or one of
// its URIs is refused: its reader says so. Parses the document: for files that no sandbox has to keep apart.
std::vector<std::string> files_named_by(std::span<const std::byte> gltf);

// Writes the archive: entries as they are, without compression, times or attributes.
class BundleWriter {
 public:
  // Given the next bytes of the archive; false: they cannot be taken.
  using Sink = std::function<bool(std::string_view piece)>;

  explicit BundleWriter(Sink sink) : sink_(std::move(sink)) {}

  // How many bytes the archive gets for one entry, its directory's record included.
  static std::uint64_t bytes_for(std::string_view path, std::uint64_t bytes);
  static std::uint64_t bytes_for_end();

  // Precondition: paths come in the order of their bytes, each once, and the archive stays within kMostBundleBytes.
  // False: the sink said so.
  bool add(std::string_view path, std::span<const std::byte> bytes);
  bool finish();

 private:
  bool put(std::string_view piece);

  Sink sink_;
  std::uint64_t written_ = 0;
  std::size_t entries_ = 0;
  std::string directory_;
};

}  // namespace meshgauge::api
