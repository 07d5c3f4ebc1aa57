// The JSON of a glTF file, checked and reduced to what makes its surface.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf_container.h"

namespace meshgauge::api {

struct GltfBuffer {
  std::size_t byte_length = 0;
  std::string uri;        // a data URI, or that of a file beside the document, with a path; empty for the BIN chunk
  bool fallback = false;  // may be absent: stands in for what meshopt compresses
  bool is_external() const { return !fallback && !uri.empty() && !uri.starts_with("data:"); }
};

// A primitive's KHR_draco_mesh_compression.
struct GltfDraco {
  std::size_t view = 0;
  std::map<std::string, std::uint32_t> ids;  // of the attributes in the stream, by name
};

// What tinygltf must not see of a primitive: it refuses indices without a bufferView.
struct GltfFaces {
  std::optional<std::size_t> indices;  // accessor
  std::optional<GltfDraco> draco;
};

// A bufferView's EXT_meshopt_compression or KHR_meshopt_compression.
struct GltfMeshopt {
  std::size_t buffer = 0;
  std::size_t offset = 0;
  std::size_t length = 0;
  std::size_t stride = 0;
  std::size_t count = 0;
  std::string mode;
  std::string filter;
};

// A node's EXT_mesh_gpu_instancing: accessors.
struct GltfInstancing {
  std::optional<std::size_t> translation;
  std::optional<std::size_t> rotation;
  std::optional<std::size_t> scale;
};

struct GltfDocument {
  std::string json;  // asset, scene, scenes, nodes, skins, meshes, accessors and bufferViews, their known members only
  std::vector<GltfBuffer> buffers;
  bool quantized = false;                            // KHR_mesh_quantization is in use
  std::vector<std::vector<GltfFaces>> faces;         // of each primitive of each mesh
  std::map<std::size_t, GltfMeshopt> meshopt;        // by bufferView
  std::map<std::size_t, GltfInstancing> instancing;  // by node
  std::set<std::size_t> hidden;                      // nodes, by KHR_node_visibility: with all below them
};

// tinygltf takes a member of a wrong type as absent and cuts integers to 32 bits, so that a broken file would give
// another mesh without a word; it also recurses as deep as the JSON nests. Therefore nothing reaches it unchecked:
// depth and number of values first, then JSON, types, integer ranges, the version, the extensions and the URIs.
// Of a key that stands twice in an object, the last counts.
Result<GltfDocument> check_gltf(const Source& source, std::string_view text);

}  // namespace meshgauge::api
