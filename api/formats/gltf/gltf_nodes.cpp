#include "api/formats/gltf/gltf_nodes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

namespace meshgauge::api {
namespace {

// Returns the rotation by a quaternion, normalised since files store it rounded to float. nullopt: its length is 0 or
// not finite.
std::optional<Eigen::Matrix3d> rotation_of(const Eigen::Vector4d& xyzw) {
  const auto square = [&](int k) { return xyzw[k] * xyzw[k]; };
  const double length = std::sqrt((square(0) + square(2)) + (square(1) + square(3)));
  if (!(length > 0x1p-500) || !(length < 0x1p500)) return std::nullopt;
  const Eigen::Vector4d unit = xyzw / length;
  return Eigen::Quaterniond(unit[3], unit[0], unit[1], unit[2]).toRotationMatrix();
}

void scale_by(const Vec3& factors, GltfTransform& transform) {
  for (int k = 0; k < 3; ++k) transform.linear.col(k) *= factors[k];
}

}  // namespace

Result<GltfTransform> gltf_local_transform(const GltfFile& file, std::size_t index) {
  const tinygltf::Node& node = file.model.nodes[index];
  GltfTransform out;
  if (!node.matrix.empty()) {
    const Eigen::Map<const Eigen::Matrix4d> matrix(node.matrix.data());
    if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return file.fail(gltf_item("nodes", index) + ".matrix", "the last row must be 0 0 0 1");
    }
    return GltfTransform{matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()};
  }
  if (!node.translation.empty()) out.translation = Vec3(node.translation.data());
  if (!node.rotation.empty()) {
    const auto rotation = rotation_of(Eigen::Vector4d(node.rotation.data()));
    if (!rotation)
      return file.fail(gltf_item("nodes", index) + ".rotation", "a quaternion of length zero or too large");
    out.linear = *rotation;
  }
  if (!node.scale.empty()) scale_by(Vec3(node.scale.data()), out);
  return out;
}

Result<std::vector<GltfTransform>> gltf_instances(const GltfFile& file, std::size_t node,
                                                  const GltfInstancing& instancing, std::size_t most) {
  const std::string where = gltf_item("nodes", node) + ".extensions.EXT_mesh_gpu_instancing";
  bool is_placed = false;
  for (const auto& accessor : {instancing.translation, instancing.scale, instancing.rotation}) {
    if (!accessor) continue;
    is_placed = true;
    // Checks before allocating: an accessor without bytes may claim any count.
    if (*accessor < file.model.accessors.size() && file.model.accessors[*accessor].count > most) {
      return too_many(file.source, "instances", most);
    }
  }
  // Without these attributes all instances lie at the node, so one of them is the whole surface.
  if (!is_placed) return std::vector<GltfTransform>(1);
  std::vector<Vec3> translations;
  std::vector<Vec3> scales;
  std::vector<Eigen::Vector4d> rotations;
  const auto take = [](auto read, auto& out) -> Result<Done> {
    if (!read) return std::move(read).error();
    out = *std::move(read);
    return Done{};
  };
  Result<Done> ok = Done{};
  if (instancing.translation) ok = take(file.accessors.floats(*instancing.translation, "TRANSLATION"), translations);
  if (ok && instancing.scale) ok = take(file.accessors.floats(*instancing.scale, "SCALE"), scales);
  if (ok && instancing.rotation) ok = take(file.accessors.rotations(*instancing.rotation), rotations);
  if (!ok) return std::move(ok).error();
  const std::size_t count = std::max({translations.size(), scales.size(), rotations.size()});
  const bool same_counts = (!instancing.translation || translations.size() == count) &&
                           (!instancing.scale || scales.size() == count) &&
                           (!instancing.rotation || rotations.size() == count);
  if (!same_counts) return file.fail(where, "its attributes have different counts");
  std::vector<GltfTransform> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!translations.empty()) out[i].translation = translations[i];
    if (!rotations.empty()) {
      const auto rotation = rotation_of(rotations[i]);
      if (!rotation)
        return file.fail(where, "instance " + std::to_string(i) + " has a quaternion of length zero or too large");
      out[i].linear = *rotation;
    }
    if (!scales.empty()) scale_by(scales[i], out[i]);
  }
  return out;
}

Result<Done> GltfWorld::find_parents() {
  const auto& nodes = file_.model.nodes;
  parents_.resize(nodes.size());
  known_.resize(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const int child : nodes[i].children) {
      const auto index = static_cast<std::size_t>(child);
      if (index >= nodes.size()) {
        return file_.fail(gltf_item("nodes", i), gltf_item("nodes", index) + " does not exist");
      }
      if (parents_[index]) return file_.fail(gltf_item("nodes", index), "several parents");
      parents_[index] = i;
    }
  }
  return Done{};
}

Result<GltfTransform> GltfWorld::of(std::size_t node) {
  if (node >= file_.model.nodes.size()) return file_.fail(gltf_item("nodes", node), "does not exist");
  if (parents_.empty()) {
    if (auto ok = find_parents(); !ok) return std::move(ok).error();
  }
  std::vector<std::size_t> unknown;  // nodes from `node` up to the first ancestor with a known transform
  for (std::optional<std::size_t> at = node; at && !known_[*at]; at = parents_[*at]) {
    if (unknown.size() == parents_.size()) return file_.fail(gltf_item("nodes", node), "in a cycle of nodes");
    unknown.push_back(*at);
  }
  for (; !unknown.empty(); unknown.pop_back()) {
    const std::size_t at = unknown.back();
    const auto local = gltf_local_transform(file_, at);
    if (!local) return local.error();
    known_[at] = parents_[at] ? composed(*known_[*parents_[at]], *local) : *local;
  }
  return *known_[node];
}

}  // namespace meshgauge::api
