// Decodes KHR_draco_mesh_compression, by libdraco.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_accessor.h"
#include "api/formats/gltf/gltf_views.h"

namespace meshgauge::api {

struct GltfDracoMesh {
  std::vector<std::uint32_t> corners;  // three for each triangle, each below `points`
  std::size_t points = 0;
  std::map<std::string, GltfColumn> columns;  // the requested attributes, by name
};

// Decodes a stream. `ids`: the requested attributes, by name. `where`: the place in messages. The sizes that the stream
// claims are checked against the limits and the budget before memory is allocated; libdraco uses about ten times those
// bytes while it decodes. Throws std::bad_alloc.
Result<GltfDracoMesh> decode_draco(const Source& source, const std::string& where, std::span<const std::byte> stream,
                                   const std::map<std::string, std::uint32_t>& ids, GltfBudget& budget);

}  // namespace meshgauge::api
