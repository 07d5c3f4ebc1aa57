// Locates the JSON and the binary data of a glTF file.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "api/formats/file/source.h"

namespace meshgauge::api {

struct GltfContainer {
  std::string_view json;
  std::optional<std::span<const std::byte>> binary;  // the BIN chunk of a GLB
  std::size_t trailing = 0;                          // bytes after the end of a GLB
  // Returns the bytes of a file beside the document, by its path (api/formats/file/file_path.h); nullopt: no such file.
  // They live as long as the container. A null function: the document came alone.
  std::function<Result<std::optional<std::span<const std::byte>>>(const std::string& path)> file;
};

// Opens a GLB of version 2: a JSON chunk, then at most one BIN chunk; later chunks of unknown types are ignored, as
// glTF 2.0 requires. Counts the bytes after its end; refuses another GLB or a JSON or BIN chunk there. Borrows from the
// source.
Result<GltfContainer> open_glb(const Source& source);
GltfContainer open_gltf(const Source& source);

// Returns the error for glTF 1.0, which is not supported.
Error gltf_1_error(const Source& source);

}  // namespace meshgauge::api
