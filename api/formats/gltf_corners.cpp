#include "api/formats/gltf_corners.h"

namespace meshgauge::api {
namespace {

std::uint32_t restart_index(int component_type) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return 0xFF;
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 0xFFFF : 0xFFFFFFFF;
}

}  // namespace

Result<std::vector<std::uint32_t>> gltf_corners(const GltfFile& file, const GltfFaces& faces, const std::string& where,
                                                std::size_t vertices) {
  if (!faces.indices) {
    std::vector<std::uint32_t> all(vertices);
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    return all;
  }
  auto read = file.accessors.indices(*faces.indices);
  if (!read) return read;
  const std::uint32_t restart = restart_index(file.model.accessors[*faces.indices].componentType);
  for (std::size_t i = 0; i < read->size(); ++i) {
    if ((*read)[i] == restart) {
      return file.fail(where, "index " + std::to_string(restart) + " at place " + std::to_string(i) +
                                  ", the largest of its type, which restarts a primitive in some programs and which "
                                  "glTF does not allow; save the model with separate primitives or wider indices");
    }
    if ((*read)[i] < vertices) continue;
    return at(file.source, where, ErrorCode::index_out_of_range,
              "index " + std::to_string((*read)[i]) + " at place " + std::to_string(i) + ", but there are " +
                  std::to_string(vertices) + " vertices");
  }
  return read;
}

}  // namespace meshgauge::api
