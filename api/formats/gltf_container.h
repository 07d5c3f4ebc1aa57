// Where the JSON and the binary data of a glTF file are.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "api/formats/source.h"

namespace meshgauge::api {

struct GltfContainer {
  std::string_view json;
  std::optional<std::span<const std::byte>> binary;  // the BIN chunk of a GLB
  // The bytes of a file beside the document, by its path (api/formats/file_path.h); nullopt: there is none of that
  // path. They live as long as the container. Null: there are no files beside it.
  std::function<Result<std::optional<std::span<const std::byte>>>(const std::string& path)> file;
};

// Borrows from the source. GLB: version 2, a JSON chunk, then at most one BIN chunk; chunks of unknown types after
// them are passed over, as the standard asks.
Result<GltfContainer> open_glb(const Source& source);
GltfContainer open_gltf(const Source& source);

// The refusal of glTF 1.0, which no reader here takes.
Error gltf_1_error(const Source& source);

}  // namespace meshgauge::api
