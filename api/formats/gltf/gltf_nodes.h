// Transforms of a glTF's nodes and instances.
#pragma once

#include <optional>
#include <vector>

#include "api/formats/file/affine_map.h"
#include "api/formats/gltf/gltf_file.h"

namespace meshgauge::api {

using GltfTransform = AffineMap;

// Returns the transform from a node to its parent.
Result<GltfTransform> gltf_local_transform(const GltfFile& file, std::size_t index);

// Returns the transform from each instance to the node. Refuses more than `most` instances.
Result<std::vector<GltfTransform>> gltf_instances(const GltfFile& file, std::size_t node,
                                                  const GltfInstancing& instancing, std::size_t most);

// Transforms from nodes to world space, each computed once. A parent is any node that names the child, also outside the
// scene.
class GltfWorld {
 public:
  explicit GltfWorld(const GltfFile& file) : file_(file) {}

  // Refuses a node that does not exist, has several parents, or is its own ancestor.
  Result<GltfTransform> of(std::size_t node);

 private:
  Result<Done> find_parents();

  const GltfFile& file_;
  std::vector<std::optional<std::size_t>> parents_;  // empty before the first of()
  std::vector<std::optional<GltfTransform>> known_;
};

}  // namespace meshgauge::api
