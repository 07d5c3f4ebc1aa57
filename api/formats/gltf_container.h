// Where the JSON and the binary data of a glTF file are.
#pragma once

#include <optional>

#include "api/formats/source.h"

namespace meshgauge::api {

struct GltfContainer {
  std::string_view json;
  std::optional<std::span<const std::byte>> binary;  // the BIN chunk of a GLB
};

// Borrows from the source. GLB: version 2, a JSON chunk, then at most one BIN chunk; chunks of unknown types after
// them are passed over, as the standard asks.
Result<GltfContainer> open_glb(const Source& source);
GltfContainer open_gltf(const Source& source);

}  // namespace meshgauge::api
