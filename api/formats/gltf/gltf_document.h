// Checks the JSON of a glTF file and reduces it to what makes up its surface.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf/gltf_container.h"
#include "api/formats/unread.h"

namespace meshgauge::api {

struct GltfBuffer {
  std::size_t byte_length = 0;
  std::string uri;        // a data URI, or the URI of a file beside the document; empty: the BIN chunk
  bool fallback = false;  // may be absent: replaces data that meshopt compresses
  bool is_external() const { return !fallback && !uri.empty() && !uri.starts_with("data:"); }
};

// KHR_draco_mesh_compression of a primitive.
struct GltfDraco {
  std::size_t view = 0;
  std::map<std::string, std::uint32_t> ids;  // attribute ids in the stream, by name
};

// The part of a primitive that is kept from tinygltf, which refuses indices without a bufferView.
struct GltfFaces {
  std::optional<std::size_t> indices;  // accessor
  std::optional<GltfDraco> draco;
  bool foreign = false;  // has an extension that is counted as unread, and may do without POSITION and a known mode
};

// EXT_meshopt_compression or KHR_meshopt_compression of a bufferView.
struct GltfMeshopt {
  std::size_t buffer = 0;
  std::size_t offset = 0;
  std::size_t length = 0;
  std::size_t stride = 0;
  std::size_t count = 0;
  std::string mode;
  std::string filter;
};

// EXT_mesh_gpu_instancing of a node: indices of accessors.
struct GltfInstancing {
  std::optional<std::size_t> translation;
  std::optional<std::size_t> rotation;
  std::optional<std::size_t> scale;
};

struct GltfDocument {
  std::string json;  // asset, scene, scenes, nodes, skins, meshes, accessors and bufferViews, their known members only
  std::vector<GltfBuffer> buffers;
  std::vector<std::optional<std::size_t>> strides;   // [bufferView]: its byteStride, which tinygltf would refuse if odd
  bool quantized = false;                            // KHR_mesh_quantization is used
  std::vector<std::vector<GltfFaces>> faces;         // [mesh][primitive]
  std::map<std::size_t, GltfMeshopt> meshopt;        // key: bufferView
  std::map<std::size_t, GltfInstancing> instancing;  // key: node
  std::set<std::size_t> hidden;                      // nodes hidden, with all below them (KHR_node_visibility)
  Unread unread;
  std::vector<std::string> remarks;
};

// Checks depth and number of values, then JSON syntax, types, integer ranges, the version, the extensions and the URIs.
// tinygltf would take a member of a wrong type as absent, truncate integers to 32 bits and recurse as deep as the JSON
// nests: a broken file would silently give another mesh. Of duplicate keys in an object the last counts.
Result<GltfDocument> check_gltf(const Source& source, std::string_view text);

}  // namespace meshgauge::api
