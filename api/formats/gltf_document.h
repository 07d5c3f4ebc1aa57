// The JSON of a glTF file, checked and reduced to what makes its surface.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf_container.h"

namespace meshgauge::api {

struct GltfBuffer {
  std::size_t byte_length = 0;
  std::string uri;  // a data URI, or that of a file beside the document, with a path; empty for the BIN chunk
  bool is_external() const { return !uri.empty() && !uri.starts_with("data:"); }
};

struct GltfDocument {
  std::string json;  // asset, scene, scenes, nodes, meshes, accessors and bufferViews, their known members only
  std::vector<GltfBuffer> buffers;
  bool quantized = false;  // KHR_mesh_quantization is in use
};

// tinygltf takes a member of a wrong type as absent and cuts integers to 32 bits, so that a broken file would give
// another mesh without a word; it also recurses as deep as the JSON nests. Therefore nothing reaches it unchecked:
// depth and number of values first, then JSON, types, integer ranges, the version, the extensions and the URIs.
// Of a key that stands twice in an object, the last counts.
Result<GltfDocument> check_gltf(const Source& source, std::string_view text);

}  // namespace meshgauge::api
