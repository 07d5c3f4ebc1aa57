// Transforms of a glTF's nodes and instances.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "api/formats/gltf_file.h"

namespace meshgauge::api {

using GltfTransform = Eigen::Affine3d;

// Of a node to its parent.
Result<GltfTransform> gltf_local_transform(const GltfFile& file, std::size_t index);

// Of each instance to the node. Refuses more than `most`.
Result<std::vector<GltfTransform>> gltf_instances(const GltfFile& file, std::size_t node,
                                                  const GltfInstancing& instancing, std::size_t most);

// Transforms of nodes to the world, each made once. Parents are all nodes that name a child, also outside of the scene.
class GltfWorld {
 public:
  explicit GltfWorld(const GltfFile& file) : file_(file) {}

  // Refuses a node that does not exist, has several parents, or is its own ancestor.
  Result<GltfTransform> of(std::size_t node);

 private:
  Result<Done> find_parents();

  const GltfFile& file_;
  std::vector<std::optional<std::size_t>> parents_;  // empty until asked for
  std::vector<std::optional<GltfTransform>> known_;
};

}  // namespace meshgauge::api
