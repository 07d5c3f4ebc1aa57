// Morph targets and skins, which move the vertices of a primitive before its node places them.
#pragma once

#include <map>
#include <vector>

#include "api/formats/gltf/gltf_draco.h"
#include "api/formats/gltf/gltf_file.h"
#include "api/formats/gltf/gltf_nodes.h"

namespace meshgauge::api {

// A primitive with what its deformations need. Borrows.
struct GltfShape {
  const tinygltf::Primitive& primitive;
  std::string where;           // for messages
  const GltfDracoMesh* draco;  // nullptr: not compressed by Draco

  const GltfColumn* column(const std::string& attribute) const;  // nullptr: read the accessor's bytes
};

class GltfDeformer {
 public:
  explicit GltfDeformer(const GltfFile& file) : file_(file), world_(file) {}

  // Adds the displacements of the targets times their weights; a missing weight is 0. Precondition: one position for
  // each vertex.
  Result<Done> morph(const GltfShape& shape, const std::vector<double>& weights, std::vector<Vec3>& positions);

  // Moves each vertex to world space by the joints that its weights name. Divides the weights by their sum, which must
  // be 1 up to rounding.
  Result<Done> skin(const GltfShape& shape, std::size_t skin, std::vector<Vec3>& positions);

 private:
  using Transforms = std::vector<GltfTransform>;

  Result<const Transforms*> joints(std::size_t skin);
  Result<Transforms> make_joints(std::size_t index);

  const GltfFile& file_;
  GltfWorld world_;
  std::map<std::size_t, Transforms> skins_;
};

}  // namespace meshgauge::api
