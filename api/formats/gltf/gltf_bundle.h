// Bundles a glTF of several files: a zip archive of the .gltf and the files that its buffers name. Digest, store,
// caches, sandbox and batches see the bundle's bytes alone. The same files always give the same bytes (docs/formats.md
// has the layout; server/web/page/form/pairing.ts makes it in the browser).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/file/file_path.h"
#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::string_view kBundleScene = "scene.gltf";  // the .gltf's name in the archive
inline constexpr std::size_t kMostBundleFiles = 64;             // beside the .gltf
inline constexpr std::uint64_t kMostBundleBytes = (std::uint64_t{1} << 32U) - 1;

// Returns true when the bytes begin like the JSON of a .gltf.
bool is_gltf_json(std::span<const std::byte> bytes);

// Returns true when a file at this path counts as a .gltf: an archive has exactly one.
bool is_scene_path(std::string_view path);

// Returns the distinct paths of the files that the buffers of a .gltf name, sorted; empty also when the document or one
// of its URIs is invalid, which its reader reports. Parses the document outside the sandbox: only for trusted files.
std::vector<std::string> files_named_by(std::span<const std::byte> gltf);

// Writes the archive: entries uncompressed, without times or attributes.
class BundleWriter {
 public:
  // Takes the next bytes of the archive; returns false on failure.
  using Sink = std::function<bool(std::string_view piece)>;

  explicit BundleWriter(Sink sink) : sink_(std::move(sink)) {}

  // Returns the bytes that one entry takes in the archive, its directory record included.
  static std::uint64_t bytes_for(std::string_view path, std::uint64_t bytes);
  static std::uint64_t bytes_for_end();

  // Appends an entry. Returns false when the sink failed. Precondition: paths come in ascending order of their bytes,
  // each once, and the archive stays within kMostBundleBytes.
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
