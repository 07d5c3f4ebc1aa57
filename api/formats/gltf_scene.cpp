#include "api/formats/gltf_scene.h"

#include <algorithm>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "api/formats/fan.h"
#include "api/formats/room.h"

namespace meshgauge::api {
namespace {

using Transform = Eigen::Affine3d;

Error fail(const Source& source, const std::string& where, const std::string& what) {
  return at(source, where, ErrorCode::unreadable_mesh, what);
}

std::string item(const char* array, std::size_t index) { return array + ("[" + std::to_string(index) + "]"); }

Result<Transform> local_transform(const Source& source, const tinygltf::Node& node, std::size_t index) {
  Transform out = Transform::Identity();
  if (!node.matrix.empty()) {
    const Eigen::Map<const Eigen::Matrix4d> matrix(node.matrix.data());
    if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return fail(source, item("nodes", index) + ".matrix", "the last row must be 0 0 0 1");
    }
    out.matrix() = matrix;
    return out;
  }
  if (!node.translation.empty()) out.translate(Vec3(node.translation.data()));
  if (!node.rotation.empty()) {
    const Eigen::Map<const Eigen::Quaterniond> rotation(node.rotation.data());  // x y z w in both
    if (!(rotation.norm() > 0x1p-500) || !(rotation.norm() < 0x1p500)) {
      return fail(source, item("nodes", index) + ".rotation", "a quaternion without a direction");
    }
    out.rotate(rotation.normalized());  // stored with the rounding of floats
  }
  if (!node.scale.empty()) out.scale(Vec3(node.scale.data()));
  return out;
}

// Walks the scene without recursion: a chain of nodes may be as long as the file.
class Scene {
 public:
  Scene(const Source& source, const tinygltf::Model& model, const GltfAccessors& accessors)
      : source_(source),
        model_(model),
        accessors_(accessors),
        visited_(model.nodes.size(), false),
        shown_(model.meshes.size(), false) {}

  Result<ReadMesh> read();

 private:
  struct Visit {
    std::size_t node;
    Transform parent;
  };

  Result<std::vector<int>> roots() const;
  Result<Done> push(const std::vector<int>& nodes, const std::string& where, const Transform& parent);
  Result<Done> visit(const Visit& visit);
  Result<Done> mesh(std::size_t index, const Transform& to_world);
  Result<Done> primitive(const tinygltf::Primitive& primitive, const std::string& where, const Transform& to_world);
  Result<std::uint32_t> place_vertices(std::size_t accessor, const Transform& to_world);
  Result<std::vector<std::uint32_t>> corners(const tinygltf::Primitive& primitive, const std::string& where,
                                             std::size_t vertices) const;
  Result<Done> triangles(int mode, const std::vector<std::uint32_t>& corners, std::uint32_t first,
                         const std::string& where);

  const Source& source_;
  const tinygltf::Model& model_;
  const GltfAccessors& accessors_;
  std::vector<bool> visited_;  // nodes
  std::vector<bool> shown_;    // meshes
  std::vector<Visit> stack_;
  std::map<std::size_t, std::uint32_t> placed_;  // of the mesh at hand: accessor of positions -> first vertex
  ReadMesh out_;
};

Result<std::vector<int>> Scene::roots() const {
  const std::size_t scene = model_.defaultScene < 0 ? 0 : static_cast<std::size_t>(model_.defaultScene);
  if (scene < model_.scenes.size()) return model_.scenes[scene].nodes;
  if (model_.defaultScene >= 0) return fail(source_, "scene", std::to_string(scene) + " does not exist");
  std::vector<bool> is_child(model_.nodes.size(), false);
  for (const tinygltf::Node& node : model_.nodes) {
    for (const int child : node.children) {
      if (static_cast<std::size_t>(child) < is_child.size()) is_child[static_cast<std::size_t>(child)] = true;
    }
  }
  std::vector<int> out;
  for (std::size_t i = 0; i < is_child.size(); ++i) {
    if (!is_child[i]) out.push_back(static_cast<int>(i));
  }
  return out;
}

// A node has at most one parent; so each is visited once, and neither a cycle nor a doubling ladder goes on.
Result<Done> Scene::push(const std::vector<int>& nodes, const std::string& where, const Transform& parent) {
  for (std::size_t i = nodes.size(); i-- > 0;) {  // the last one in is visited first
    const auto index = static_cast<std::size_t>(nodes[i]);
    if (index >= visited_.size()) return fail(source_, where, item("nodes", index) + " does not exist");
    if (visited_[index]) {
      return fail(source_, item("nodes", index), "used twice: several parents, or a cycle of nodes");
    }
    visited_[index] = true;
    stack_.push_back({index, parent});
  }
  return Done{};
}

Result<ReadMesh> Scene::read() {
  out_.notes.unit = LengthUnit::meter;  // of every glTF (glTF 2.0, section 3.4)
  const auto top = roots();
  if (!top) return top.error();
  if (auto ok = push(*top, "the scene", Transform::Identity()); !ok) return std::move(ok).error();
  while (!stack_.empty()) {
    const Visit next = stack_.back();
    stack_.pop_back();
    if (auto ok = visit(next); !ok) return std::move(ok).error();
  }
  out_.notes.unused_objects = static_cast<std::size_t>(std::ranges::count(shown_, false));
  return std::move(out_);
}

Result<Done> Scene::visit(const Visit& visit) {
  const tinygltf::Node& node = model_.nodes[visit.node];
  const auto local = local_transform(source_, node, visit.node);
  if (!local) return local.error();
  const Transform to_world = visit.parent * *local;
  if (node.mesh >= 0) {
    if (auto ok = mesh(static_cast<std::size_t>(node.mesh), to_world); !ok) return ok;
  }
  return push(node.children, item("nodes", visit.node), to_world);
}

Result<Done> Scene::mesh(std::size_t index, const Transform& to_world) {
  if (index >= model_.meshes.size()) return fail(source_, item("meshes", index), "does not exist");
  shown_[index] = true;
  placed_.clear();
  const auto& primitives = model_.meshes[index].primitives;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    auto ok = primitive(primitives[i], item("meshes", index) + "." + item("primitives", i), to_world);
    if (!ok) return ok;
  }
  return Done{};
}

Result<Done> Scene::primitive(const tinygltf::Primitive& primitive, const std::string& where,
                              const Transform& to_world) {
  if (primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    ++out_.notes.skipped_primitives;
    return Done{};
  }
  if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    return fail(source_, where, "mode " + std::to_string(primitive.mode) + " does not exist");
  }
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return fail(source_, where, "no attribute POSITION");
  const auto accessor = static_cast<std::size_t>(position->second);
  const auto first = place_vertices(accessor, to_world);
  if (!first) return first.error();
  const auto used = corners(primitive, where, model_.accessors[accessor].count);
  if (!used) return used.error();
  return triangles(primitive.mode, *used, *first, where);
}

// Primitives of a mesh often share their vertices.
Result<std::uint32_t> Scene::place_vertices(std::size_t accessor, const Transform& to_world) {
  if (const auto known = placed_.find(accessor); known != placed_.end()) return known->second;
  auto local = accessors_.positions(accessor);
  if (!local) return std::move(local).error();
  std::vector<Vec3>& world = out_.mesh.positions;
  if (local->size() > vertex_limit(source_) - world.size()) {
    return too_many(source_, "vertices", vertex_limit(source_));
  }
  const auto first = static_cast<std::uint32_t>(world.size());
  reserve_more(world, local->size());
  for (const Vec3& p : *local) world.push_back(to_world * p);
  placed_.emplace(accessor, first);
  return first;
}

Result<std::vector<std::uint32_t>> Scene::corners(const tinygltf::Primitive& primitive, const std::string& where,
                                                  std::size_t vertices) const {
  std::vector<std::uint32_t> out;
  if (primitive.indices < 0) {
    out.resize(vertices);
    for (std::size_t i = 0; i < vertices; ++i) out[i] = static_cast<std::uint32_t>(i);
    return out;
  }
  auto read = accessors_.indices(static_cast<std::size_t>(primitive.indices));
  if (!read) return read;
  for (std::size_t i = 0; i < read->size(); ++i) {
    if ((*read)[i] < vertices) continue;
    return at(source_, where, ErrorCode::index_out_of_range,
              "index " + std::to_string((*read)[i]) + " at place " + std::to_string(i) + ", but there are " +
                  std::to_string(vertices) + " vertices");
  }
  return read;
}

Result<Done> Scene::triangles(int mode, const std::vector<std::uint32_t>& corners, std::uint32_t first,
                              const std::string& where) {
  const bool separate = mode == TINYGLTF_MODE_TRIANGLES;
  if (separate && corners.size() % 3 != 0) {
    return fail(source_, where, std::to_string(corners.size()) + " corners are no whole number of triangles");
  }
  const std::size_t count = separate ? corners.size() / 3 : (corners.size() < 3 ? 0 : corners.size() - 2);
  if (count > source_.limits.max_triangles - out_.mesh.triangles.size()) {
    return too_many(source_, "triangles", source_.limits.max_triangles);
  }
  reserve_more(out_.mesh.triangles, count);
  if (separate) {
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      out_.mesh.triangles.push_back({first + corners[i], first + corners[i + 1], first + corners[i + 2]});
    }
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    Fan fan(out_.mesh.triangles);
    for (const std::uint32_t corner : corners) fan.add(first + corner);
  } else {
    Strip strip(out_.mesh.triangles);
    for (const std::uint32_t corner : corners) strip.add(first + corner);
    out_.notes.skipped_primitives += strip.joins();
  }
  return Done{};
}

}  // namespace

Result<ReadMesh> read_gltf_scene(const Source& source, const tinygltf::Model& model, const GltfAccessors& accessors) {
  return Scene(source, model, accessors).read();
}

}  // namespace meshgauge::api
