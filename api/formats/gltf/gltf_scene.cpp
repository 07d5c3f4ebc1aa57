#include "api/formats/gltf/gltf_scene.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_deform.h"
#include "api/formats/gltf/gltf_draco.h"
#include "api/formats/gltf/gltf_nodes.h"
#include "api/formats/polygons/polygons.h"

namespace meshgauge::api {
namespace {

std::uint32_t restart_index(int component_type) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return 0xFF;
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 0xFFFF : 0xFFFFFFFF;
}

// Returns the indices of a primitive; all its vertices in order if it has none. Refuses an index without a vertex, and
// the largest index of its type, which restarts a primitive. `where`: the primitive in messages.
Result<LargeArray<std::uint32_t>> gltf_corners(const GltfFile& file, const GltfFaces& faces, const std::string& where,
                                               std::size_t vertices) {
  if (!faces.indices) {
    LargeArray<std::uint32_t> all(vertices);
    std::iota(all.begin(), all.end(), std::uint32_t{0});
    return all;
  }
  auto read = file.accessors.indices(*faces.indices);
  if (!read) return read;
  const std::uint32_t restart = restart_index(file.model.accessors[*faces.indices].componentType);
  std::uint32_t highest = 0;
  for (const std::uint32_t index : *read) highest = std::max(highest, index);
  if (read->empty() || (highest < vertices && highest < restart)) return read;
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

// Walks the scene without recursion, since a chain of nodes may be as long as the file.
class Scene {
 public:
  explicit Scene(const GltfFile& file)
      : file_(file),
        deformer_(file),
        visited_(file.model.nodes.size(), false),
        in_scene_(file.model.meshes.size(), false) {}

  Result<ReadMesh> read();
  Result<ReadMesh> read_cloud();  // the primitives of points alone
  // Whether read() has found points, but no triangles.
  bool found_cloud() const { return found_cloud_; }

 private:
  struct Visit {
    std::size_t node;
    GltfTransform parent;
    bool hidden;                            // true: a node above is hidden
    std::optional<std::size_t> first = {};  // set: the node's subtree, which began with this triangle, is done
  };
  // The placement of a mesh by its node.
  struct Placing {
    GltfTransform to_world;
    std::optional<std::size_t> skin;     // if set, it places the mesh instead of to_world
    const std::vector<double>& weights;  // weights of the morph targets
  };
  // Counts for the remarks, and of primitives.
  struct Counts {
    std::size_t points = 0;
    std::size_t others = 0;  // primitives of lines and triangles
    std::size_t instances = 0;
    std::size_t hidden = 0;         // hidden nodes with a mesh
    std::set<std::size_t> skinned;  // indices of meshes
    std::set<std::size_t> morphed;
    std::size_t left_over = 0;  // corners of incomplete last triangles
  };

  Result<std::vector<int>> roots() const;
  Result<Done> push(const std::vector<int>& nodes, const std::string& where, const GltfTransform& parent, bool hidden);
  Result<Done> visit(const Visit& visit);
  Result<Done> node_mesh(std::size_t index, const GltfTransform& to_world, bool hidden);
  Result<Done> instances(std::size_t node, const GltfInstancing& instancing, const Placing& placing);
  Result<Done> mesh(std::size_t index, const Placing& placing);
  Result<Done> primitive(std::size_t mesh, std::size_t index, const Placing& placing);
  Result<const GltfDracoMesh*> draco(std::size_t mesh, std::size_t index, const std::string& where);
  Result<std::uint32_t> place_vertices(const GltfShape& shape, std::size_t accessor, const Placing& placing);
  Result<std::vector<Vec3>> local_vertices(const GltfShape& shape, std::size_t accessor, const Placing& placing);
  Result<Done> surface(std::size_t mesh, std::size_t index, const Placing& placing, const std::string& where);
  Result<Done> points(std::span<const std::uint32_t> corners, std::uint32_t first, const std::string& where);
  Result<Done> triangles(int mode, std::span<const std::uint32_t> corners, std::uint32_t first,
                         const std::string& where);
  void separate_triangles(std::span<const std::uint32_t> corners, std::uint32_t first);
  std::size_t nodes_left_out() const;
  void add_remarks();

  const GltfFile& file_;
  GltfDeformer deformer_;
  std::vector<bool> visited_;   // by node
  std::vector<bool> in_scene_;  // by mesh, also hidden ones
  std::vector<Visit> stack_;
  std::map<std::pair<std::size_t, std::size_t>, GltfDracoMesh> draco_;  // key: mesh, primitive
  std::map<std::size_t, std::uint32_t> placed_;  // current mesh: accessor of positions -> first vertex
  Counts counts_;
  bool found_cloud_ = false;
  GroupCollector groups_;
  ReadMesh out_;
};

// Returns the root nodes. Refuses a scene that names a child of another node: it would be placed without that node's
// transform.
Result<std::vector<int>> Scene::roots() const {
  std::vector<bool> is_child(file_.model.nodes.size(), false);
  for (const tinygltf::Node& node : file_.model.nodes) {
    for (const int child : node.children) {
      if (static_cast<std::size_t>(child) < is_child.size()) is_child[static_cast<std::size_t>(child)] = true;
    }
  }
  const std::size_t scene = file_.model.defaultScene < 0 ? 0 : static_cast<std::size_t>(file_.model.defaultScene);
  if (scene < file_.model.scenes.size()) {
    for (const int node : file_.model.scenes[scene].nodes) {
      if (static_cast<std::size_t>(node) >= is_child.size() || !is_child[static_cast<std::size_t>(node)]) continue;
      return file_.fail(gltf_item("scenes", scene),
                        "names " + gltf_item("nodes", static_cast<std::size_t>(node)) +
                            ", which is a child of another node; a scene may name root nodes only");
    }
    return file_.model.scenes[scene].nodes;
  }
  if (file_.model.defaultScene >= 0) return file_.fail("scene", std::to_string(scene) + " does not exist");
  std::vector<int> out;
  for (std::size_t i = 0; i < is_child.size(); ++i) {
    if (!is_child[i]) out.push_back(static_cast<int>(i));
  }
  return out;
}

// Refuses a node that is visited twice, that is with several parents or in a cycle, so that the walk is linear.
Result<Done> Scene::push(const std::vector<int>& nodes, const std::string& where, const GltfTransform& parent,
                         bool hidden) {
  for (std::size_t i = nodes.size(); i-- > 0;) {  // the last node pushed is visited first
    const auto index = static_cast<std::size_t>(nodes[i]);
    if (index >= visited_.size()) return file_.fail(where, gltf_item("nodes", index) + " does not exist");
    if (visited_[index]) {
      return file_.fail(gltf_item("nodes", index), "used twice: several parents, or a cycle of nodes");
    }
    visited_[index] = true;
    stack_.push_back({index, parent, hidden});
  }
  return Done{};
}

Result<ReadMesh> Scene::read() {
  out_.notes.unit = LengthUnit::meter;  // glTF 2.0, section 3.4
  const auto top = roots();
  if (!top) return top.error();
  if (auto ok = push(*top, "the scene", GltfTransform(), false); !ok) return std::move(ok).error();
  while (!stack_.empty()) {
    const Visit next = stack_.back();
    stack_.pop_back();
    if (auto ok = visit(next); !ok) return std::move(ok).error();
  }
  out_.groups = groups_.take();
  if (counts_.hidden != 0 && out_.mesh.triangles.empty()) {
    return about(file_.source.part, ErrorCode::empty_mesh,
                 "has no triangles that are shown: KHR_node_visibility hides " + std::to_string(counts_.hidden) +
                     " nodes with meshes; save the model with them visible");
  }
  found_cloud_ = out_.mesh.triangles.empty() && counts_.points != 0 && counts_.others == 0;
  add_remarks();
  out_.notes.unused_objects = static_cast<std::size_t>(std::ranges::count(in_scene_, false));
  return std::move(out_);
}

// Indices may name a vertex more than once, or not at all: the result has one for each point.
Result<ReadMesh> Scene::read_cloud() {
  out_.notes.cloud = true;
  auto cloud = read();
  if (!cloud) return cloud;
  std::vector<Vec3> points;
  reserve_room(points, cloud->mesh.triangles.size());
  for (const Triangle& point : cloud->mesh.triangles) points.push_back(cloud->mesh.positions[point[0]]);
  cloud->mesh = {std::move(points), points_as_triangles(cloud->mesh.triangles.size())};
  return cloud;
}

Result<Done> Scene::visit(const Visit& visit) {
  const tinygltf::Node& node = file_.model.nodes[visit.node];
  if (visit.first) return groups_.add(node.name, *visit.first, out_.mesh.triangles.size()), Done{};
  if (is_group_name(node.name)) stack_.push_back({visit.node, visit.parent, false, out_.mesh.triangles.size()});
  const auto local = gltf_local_transform(file_, visit.node);
  if (!local) return local.error();
  const GltfTransform to_world = composed(visit.parent, *local);
  const bool hidden = visit.hidden || file_.document.hidden.contains(visit.node);
  if (node.mesh >= 0) {
    if (auto ok = node_mesh(visit.node, to_world, hidden); !ok) return ok;
  }
  return push(node.children, gltf_item("nodes", visit.node), to_world, hidden);
}

Result<Done> Scene::node_mesh(std::size_t index, const GltfTransform& to_world, bool hidden) {
  const tinygltf::Node& node = file_.model.nodes[index];
  const auto mesh_index = static_cast<std::size_t>(node.mesh);
  if (mesh_index >= file_.model.meshes.size()) {
    return file_.fail(gltf_item("meshes", mesh_index), "does not exist");
  }
  in_scene_[mesh_index] = true;
  if (hidden) {
    ++counts_.hidden;
    return Done{};
  }
  Placing placing{to_world, std::nullopt, node.weights.empty() ? file_.model.meshes[mesh_index].weights : node.weights};
  if (node.skin >= 0) placing.skin = static_cast<std::size_t>(node.skin);
  if (placing.skin) counts_.skinned.insert(mesh_index);
  if (const auto found = file_.document.instancing.find(index); found != file_.document.instancing.end()) {
    return instances(index, found->second, placing);
  }
  return mesh(mesh_index, placing);
}

Result<Done> Scene::instances(std::size_t node, const GltfInstancing& instancing, const Placing& placing) {
  if (placing.skin) {
    return at(file_.source, gltf_item("nodes", node), ErrorCode::unsupported_format,
              "instances of a skinned mesh are not supported");
  }
  // Each instance takes memory and time, even of an empty mesh.
  constexpr std::size_t kMostInstances = 1'000'000;
  const std::size_t limit = std::min(file_.source.limits.max_triangles, kMostInstances);
  const auto transforms = gltf_instances(file_, node, instancing, limit);
  if (!transforms) return transforms.error();
  if (transforms->size() > limit - counts_.instances) return too_many(file_.source, "instances", limit);
  counts_.instances += transforms->size();
  const auto mesh_index = static_cast<std::size_t>(file_.model.nodes[node].mesh);
  for (const GltfTransform& instance : *transforms) {
    const Placing placed{composed(placing.to_world, instance), std::nullopt, placing.weights};
    if (auto ok = mesh(mesh_index, placed); !ok) return ok;
  }
  return Done{};
}

Result<Done> Scene::mesh(std::size_t index, const Placing& placing) {
  placed_.clear();
  const auto& primitives = file_.model.meshes[index].primitives;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (!primitives[i].targets.empty()) counts_.morphed.insert(index);
    if (auto ok = primitive(index, i, placing); !ok) return ok;
  }
  return Done{};
}

Result<Done> Scene::primitive(std::size_t mesh, std::size_t index, const Placing& placing) {
  const tinygltf::Primitive& primitive = file_.model.meshes[mesh].primitives[index];
  const std::string where = gltf_item("meshes", mesh) + "." + gltf_item("primitives", index);
  constexpr std::size_t kSteps = 64;  // cost of a primitive without vertices
  const std::size_t steps_before = file_.budget.steps();
  const std::size_t triangles_before = out_.mesh.triangles.size();
  if (auto ok = file_.budget.work(kSteps, where); !ok) return ok;
  ++(primitive.mode == TINYGLTF_MODE_POINTS ? counts_.points : counts_.others);
  const bool cloud = out_.notes.cloud && primitive.mode == TINYGLTF_MODE_POINTS;
  if (primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode < TINYGLTF_MODE_TRIANGLES && !cloud) {
    ++out_.notes.skipped_primitives;
    return Done{};
  }
  const bool is_foreign = primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN || !primitive.attributes.contains("POSITION");
  if (is_foreign && file_.document.faces[mesh][index].foreign) return Done{};  // counted by count_gltf_unread()
  if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    return file_.fail(where, "mode " + std::to_string(primitive.mode) + " does not exist");
  }
  auto ok = surface(mesh, index, placing, where);
  file_.budget.refund(steps_before, out_.mesh.triangles.size() - triangles_before);
  return ok;
}

Result<Done> Scene::surface(std::size_t mesh, std::size_t index, const Placing& placing, const std::string& where) {
  const tinygltf::Primitive& primitive = file_.model.meshes[mesh].primitives[index];
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return file_.fail(where, "no attribute POSITION");
  const auto accessor = static_cast<std::size_t>(position->second);
  const GltfFaces& faces = file_.document.faces[mesh][index];
  if (!faces.draco) {
    const auto first = place_vertices({primitive, where, nullptr}, accessor, placing);
    if (!first) return first.error();
    const auto used = gltf_corners(file_, faces, where, file_.model.accessors[accessor].count);
    if (!used) return used.error();
    return triangles(primitive.mode, *used, *first, where);
  }
  if (primitive.mode == TINYGLTF_MODE_POINTS) {
    return file_.fail(where, "points compressed by Draco, which the extension does not allow; save them without it");
  }
  if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    return file_.fail(
        where, "mode 6, a triangle fan, compressed by Draco, which the extension does not allow; save it as triangles");
  }
  // Draco decodes to triangles, even if the accessors that it replaces hold a strip.
  const auto decoded = draco(mesh, index, where);
  if (!decoded) return decoded.error();
  const auto first = place_vertices({primitive, where, *decoded}, accessor, placing);
  if (!first) return first.error();
  if ((*decoded)->points != file_.model.accessors[accessor].count) {
    return file_.fail(where, "the numbers of points in POSITION and in the Draco stream differ");
  }
  return triangles(TINYGLTF_MODE_TRIANGLES, (*decoded)->corners, *first, where);
}

Result<const GltfDracoMesh*> Scene::draco(std::size_t mesh, std::size_t index, const std::string& where) {
  auto known = draco_.find({mesh, index});
  if (known == draco_.end()) {
    const GltfDraco& draco = *file_.document.faces[mesh][index].draco;
    const std::string place = where + ".extensions.KHR_draco_mesh_compression";
    const auto stream = file_.views.bytes(draco.view, place);
    if (!stream) return stream.error();
    constexpr std::size_t kSteps = 2000;  // cost of a stream without triangles
    if (auto ok = file_.budget.work(kSteps + stream->size(), place); !ok) return std::move(ok).error();
    auto decoded = decode_draco(file_.source, place, *stream, draco.ids, file_.budget);
    if (!decoded) return std::move(decoded).error();
    known = draco_.emplace(std::pair(mesh, index), *std::move(decoded)).first;
  }
  return &known->second;
}

// Returns the first vertex. Primitives of a mesh often share their vertices, which are then placed once.
Result<std::uint32_t> Scene::place_vertices(const GltfShape& shape, std::size_t accessor, const Placing& placing) {
  const bool may_share = shape.draco == nullptr && shape.primitive.targets.empty() && !placing.skin;
  if (const auto known = placed_.find(accessor); may_share && known != placed_.end()) return known->second;
  auto local = local_vertices(shape, accessor, placing);
  if (!local) return std::move(local).error();
  std::vector<Vec3>& world = out_.mesh.positions;
  const std::size_t limit = vertex_limit(file_.source);
  if (local->size() > limit - world.size()) return too_many(file_.source, "vertices", limit);
  const auto first = static_cast<std::uint32_t>(world.size());
  if (!placing.skin) {
    for (Vec3& p : *local) p = placing.to_world(p);
  }
  if (world.empty()) {
    world = *std::move(local);
  } else {
    reserve_more(world, local->size());
    world.insert(world.end(), local->begin(), local->end());
  }
  if (may_share) placed_.emplace(accessor, first);
  return first;
}

// Returns positions relative to the node, or in world space for a skinned mesh.
Result<std::vector<Vec3>> Scene::local_vertices(const GltfShape& shape, std::size_t accessor, const Placing& placing) {
  auto positions = file_.accessors.positions(accessor, "POSITION", shape.column("POSITION"));
  if (!positions) return positions;
  if (auto ok = deformer_.morph(shape, placing.weights, *positions); !ok) return std::move(ok).error();
  if (placing.skin) {
    if (auto ok = deformer_.skin(shape, *placing.skin, *positions); !ok) return std::move(ok).error();
  }
  return positions;
}

// Precondition: room for the triangles.
void Scene::separate_triangles(std::span<const std::uint32_t> corners, std::uint32_t first) {
  TriangleBlock block(out_.mesh.triangles);
  for (; corners.size() >= 3; corners = corners.subspan(3)) {
    const std::uint32_t* const p = corners.data();
    block.add({first + p[0], first + p[1], first + p[2]});
  }
  block.flush();
}

Result<Done> Scene::triangles(int mode, std::span<const std::uint32_t> corners, std::uint32_t first,
                              const std::string& where) {
  if (mode == TINYGLTF_MODE_POINTS) return points(corners, first, where);
  const bool separate = mode == TINYGLTF_MODE_TRIANGLES;
  counts_.left_over += separate ? corners.size() % 3 : (corners.size() < 3 ? corners.size() : 0);
  const std::size_t count = separate ? corners.size() / 3 : (corners.size() < 3 ? 0 : corners.size() - 2);
  if (count > file_.source.limits.max_triangles - out_.mesh.triangles.size()) {
    return too_many(file_.source, "triangles", file_.source.limits.max_triangles);
  }
  if (auto ok = file_.budget.work(corners.size(), where); !ok) return ok;
  reserve_more(out_.mesh.triangles, count);
  if (separate) {
    separate_triangles(corners, first);
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

Result<Done> Scene::points(std::span<const std::uint32_t> corners, std::uint32_t first, const std::string& where) {
  const std::size_t limit = file_.source.limits.max_triangles;
  if (corners.size() > limit - out_.mesh.triangles.size()) return too_many(file_.source, "points", limit);
  if (auto ok = file_.budget.work(corners.size(), where); !ok) return ok;
  reserve_more(out_.mesh.triangles, corners.size());
  for (const std::uint32_t corner : corners) {
    const std::uint32_t point = first + corner;
    out_.mesh.triangles.push_back({point, point, point});
  }
  return Done{};
}

// Counts nodes only where unused_objects does not count their mesh.
std::size_t Scene::nodes_left_out() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < visited_.size(); ++i) {
    const int mesh = file_.model.nodes[i].mesh;
    if (visited_[i] || mesh < 0 || static_cast<std::size_t>(mesh) >= in_scene_.size()) continue;
    if (in_scene_[static_cast<std::size_t>(mesh)]) ++count;
  }
  return count;
}

void Scene::add_remarks() {
  ReadNotes& notes = out_.notes;
  notes.add_remark("bufferViews with elements where glTF does not allow them (offset or byteStride)",
                   file_.views.odd());
  notes.add_remark("corners of incomplete last triangles, left out", counts_.left_over);
  notes.add_remark("nodes outside the scene whose mesh is also in it, left out", nodes_left_out());
  notes.add_remark("primitives decoded from Draco", draco_.size());
  notes.add_remark("bufferViews decompressed by meshopt", file_.views.decompressed());
  notes.add_remark("meshes skinned to the pose that the file stores", counts_.skinned.size());
  notes.add_remark("meshes with morph targets, taken at their default weights", counts_.morphed.size());
  notes.add_remark("nodes with a mesh that KHR_node_visibility hides, left out", counts_.hidden);
  notes.add_remark("instances by EXT_mesh_gpu_instancing", counts_.instances);
}

}  // namespace

// Points are read only if there are no triangles, beside which they are left out unread.
Result<ReadMesh> read_gltf_scene(const GltfFile& file) {
  Scene scene(file);
  auto read = scene.read();
  return read && scene.found_cloud() ? Scene(file).read_cloud() : std::move(read);
}

}  // namespace meshgauge::api
