#include "api/map/deviation_glb.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "written as it is in memory");

constexpr double kMostFloat = std::numeric_limits<float>::max();
constexpr double kCrossShare = 0.01;  // arm of the cross, as a share of the mesh's diagonal

using Float3 = std::array<float, 3>;
using Colour = std::array<std::uint16_t, 4>;
using tinygltf::Value;

const char* to_string(MapForm form) {
  switch (form) {
    case MapForm::as_is:
      return "as_is";
    case MapForm::refined:
      return "refined";
    case MapForm::decimated:
      return "decimated";
  }
  return "";
}

// Returns the translation of both nodes: on each axis where the box is at least as far from 0 as it is wide, its
// middle, else 0. Rounded to float, since some readers keep nodes in single precision.
Vec3 translation_of(const Box& box) {
  Vec3 moved = Vec3::Zero();
  const double widest = (box.high - box.low).maxCoeff();
  for (int k = 0; k < 3; ++k) {
    const double low = box.low[k], high = box.high[k];
    if ((low > 0) == (high > 0) && std::min(std::abs(low), std::abs(high)) >= widest) {
      moved[k] = static_cast<float>(low / 2 + high / 2);
    }
  }
  return moved;
}

Float3 to_float(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

Colour to_colour(double distance, const ColourScale& scale) {
  const auto linear = to_linear(colour_of(distance, scale));
  Colour colour{0, 0, 0, 0xffff};
  for (std::size_t i = 0; i < 3; ++i) colour[i] = static_cast<std::uint16_t>(std::lround(65535 * linear[i]));
  return colour;
}

Value number(double value) { return Value(value); }
Value index(std::uint32_t value) { return Value(static_cast<int>(value)); }  // at most 2^30: MeshLimits
Value point(const Vec3& p) { return Value(Value::Array{number(p.x()), number(p.y()), number(p.z())}); }
Value text(std::string value) { return Value(std::move(value)); }

Value witness_extras(const ResultWitness& witness) {
  Value::Object extras;
  extras["from_candidate"] = Value(witness.on_candidate);
  extras["from"] = point(witness.from);
  extras["from_triangle"] = index(witness.from_triangle);
  extras["to"] = point(witness.to);
  extras["to_triangle"] = index(witness.to_triangle);
  return Value(std::move(extras));
}

Value direction_extras(const ResultDirection& direction) {
  Value::Object extras;
  extras["lower"] = number(direction.lower);
  extras["upper"] = number(direction.upper);
  if (direction.witness) extras["witness"] = witness_extras(*direction.witness);
  return Value(std::move(extras));
}

Value display_extras(const DeviationMap& map) {
  Value::Object extras;
  extras["form"] = text(to_string(map.form));
  extras["vertices"] = index(static_cast<std::uint32_t>(map.candidate_vertices));
  extras["triangles"] = index(static_cast<std::uint32_t>(map.candidate_triangles));
  return Value(std::move(extras));
}

Value extras_of(const DeviationMap& map) {
  Value::Object extras;
  extras[map.scale.limited ? "limit" : "largest"] = number(map.scale.top);
  if (!map.limit_side.empty()) extras["limit_side"] = text(map.limit_side);
  if (!map.no_sides.empty()) extras["no_sides"] = text(map.no_sides);
  extras["units"] = text(map.units);
  extras["lower"] = number(map.lower);
  extras["upper"] = number(map.upper);
  extras["candidate_vertices"] = index(static_cast<std::uint32_t>(map.candidate_vertices));
  extras["candidate_triangles"] = index(static_cast<std::uint32_t>(map.candidate_triangles));
  if (map.witness) extras["witness"] = witness_extras(*map.witness);
  if (map.direction) extras["direction"] = direction_extras(*map.direction);
  extras["display"] = display_extras(map);
  return Value(std::move(extras));
}

// Builds the document and its one buffer.
class Document {
 public:
  explicit Document(const DeviationMap& map) : map_(map), box_(bounding_box(map.mesh)), moved_(translation_of(box_)) {}

  tinygltf::Model made() {
    model_.asset.version = "2.0";
    model_.asset.generator = "meshgauge";
    model_.buffers.emplace_back();
    model_.scenes.emplace_back();
    model_.defaultScene = 0;
    add_candidate();
    if (map_.witness) add_witness();
    return std::move(model_);
  }

 private:
  void add_candidate() {
    const MeshView& mesh = map_.mesh;
    tinygltf::Primitive primitive;
    primitive.mode = map_.is_cloud() ? TINYGLTF_MODE_POINTS : TINYGLTF_MODE_TRIANGLES;
    primitive.attributes["POSITION"] = positions(mesh.positions);
    primitive.attributes["COLOR_0"] = array<Colour>(
        mesh.positions.size(), TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TARGET_ARRAY_BUFFER,
        [&](std::size_t v) { return to_colour(map_.distances[v], map_.scale); });
    model_.accessors.back().normalized = true;
    primitive.attributes["_DISTANCE"] = array<float>(
        mesh.positions.size(), TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TARGET_ARRAY_BUFFER,
        [&](std::size_t v) { return static_cast<float>(map_.distances[v]); });
    if (!map_.sides.empty())
      primitive.attributes["_SIDE"] =
          array<float>(mesh.positions.size(), TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_FLOAT,
                       TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::size_t v) { return side(v); });
    if (!map_.normals.empty())
      primitive.attributes["NORMAL"] =
          array<Float3>(mesh.positions.size(), TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT,
                        TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::size_t v) { return to_float(map_.normals[v]); });
    if (!map_.is_cloud()) primitive.indices = triangles(mesh);
    tinygltf::Material material;
    material.name = "distance";
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 1;
    material.doubleSided = true;
    add_node("candidate", std::move(primitive), std::move(material)).extras = extras_of(map_);
  }

  // The side of the rounded position: that of the vertex where the distance, which errs far less, exceeds the step
  // between both.
  float side(std::size_t v) const {
    const Vec3 exact = map_.mesh.positions[v] - moved_;
    const double step = norm(exact - exact.cast<float>().cast<double>());
    return map_.distances[v] > 4 * step ? static_cast<float>(map_.sides[v]) : 0;
  }

  int triangles(MeshView mesh) {
    const int accessor =
        array<Triangle>(mesh.triangles.size(), TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, [&](std::size_t t) { return mesh.triangles[t]; });
    model_.accessors.back().count *= 3;
    return accessor;
  }

  void add_witness() {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_LINE;
    primitive.attributes["POSITION"] = positions(witness_lines());
    tinygltf::Material material;
    material.name = "witness";
    material.pbrMetallicRoughness.baseColorFactor = {1, 0, 1, 1};
    material.extensions["KHR_materials_unlit"] = Value(Value::Object{});
    model_.extensionsUsed.emplace_back("KHR_materials_unlit");
    add_node("witness", std::move(primitive), std::move(material));
  }

  std::vector<Vec3> witness_lines() const {
    const Vec3& from = map_.witness->from;
    std::vector<Vec3> ends{from, map_.witness->to};
    const double arm = kCrossShare * diagonal(box_);
    for (int k = 0; k < 3; ++k) {
      ends.push_back(within_float(from - arm * Vec3::Unit(k)));
      ends.push_back(within_float(from + arm * Vec3::Unit(k)));
    }
    return ends;
  }

  // Clamps to the range of float: a cross at its edge has shorter arms.
  Vec3 within_float(const Vec3& p) const {
    const Vec3 most = Vec3::Constant(kMostFloat);
    return (p - moved_).cwiseMin(most).cwiseMax(-most) + moved_;
  }

  tinygltf::Node& add_node(const char* name, tinygltf::Primitive primitive, tinygltf::Material material) {
    primitive.material = static_cast<int>(model_.materials.size());
    model_.materials.push_back(std::move(material));
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(std::move(primitive));
    tinygltf::Node node;
    node.name = name;
    node.mesh = static_cast<int>(model_.meshes.size());
    if (moved_ != Vec3::Zero()) node.translation = {moved_.x(), moved_.y(), moved_.z()};
    model_.meshes.push_back(std::move(mesh));
    model_.scenes[0].nodes.push_back(static_cast<int>(model_.nodes.size()));
    return model_.nodes.emplace_back(std::move(node));
  }

  // Adds an accessor with the minimum and maximum that glTF requires.
  int positions(std::span<const Vec3> points) {
    Box bounds;
    const int accessor = array<Float3>(points.size(), TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                       TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::size_t v) {
                                         const Float3 p = to_float(points[v] - moved_);
                                         bounds.extend(Vec3(p[0], p[1], p[2]));
                                         return p;
                                       });
    model_.accessors.back().minValues.assign(bounds.low.begin(), bounds.low.end());
    model_.accessors.back().maxValues.assign(bounds.high.begin(), bounds.high.end());
    return accessor;
  }

  // Adds a view and an accessor for `count` elements. The size of every element is a multiple of four bytes, so all are
  // aligned.
  template <class Element, class Make>
  int array(std::size_t count, int type, int component, int target, const Make& element) {
    std::vector<unsigned char>& data = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = count * sizeof(Element);
    view.target = target;
    data.resize(data.size() + view.byteLength);
    for (std::size_t i = 0; i < count; ++i) {
      const Element made = element(i);
      std::memcpy(data.data() + view.byteOffset + i * sizeof made, &made, sizeof made);
    }
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    model_.bufferViews.push_back(std::move(view));
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  const DeviationMap& map_;
  const Box box_;
  const Vec3 moved_;
  tinygltf::Model model_;
};

// Returns the size of the arrays; the rest of the file is a few thousand bytes.
std::uint64_t bytes_of(const DeviationMap& map) {
  return glb_bytes(map.mesh.positions.size(), map.mesh.triangles.size(), !map.sides.empty(), !map.normals.empty());
}

bool is_within_float(const Vec3& p) { return p.cwiseAbs().maxCoeff() <= kMostFloat; }

Error too_large(const std::string& what) {
  return {ErrorCode::too_large, "the deviation map cannot be a GLB: " + what + "; write a .ply", "", ""};
}

Result<Done> check(const DeviationMap& map) {
  if (bytes_of(map) > (std::uint64_t{1} << 32) - (std::uint64_t{1} << 20)) return too_large("it would exceed 4 GiB");
  for (std::size_t v = 0; v < map.mesh.positions.size(); ++v) {
    if (is_within_float(map.mesh.positions[v]) && map.distances[v] <= kMostFloat) continue;
    return too_large("vertex " + std::to_string(v) + " is beyond single precision");
  }
  if (map.witness && !(is_within_float(map.witness->from) && is_within_float(map.witness->to))) {
    return too_large("the witness is beyond single precision");
  }
  return Done{};
}

}  // namespace

std::uint64_t glb_bytes(std::uint64_t vertices, std::uint64_t triangles, bool sides, bool normals) {
  return vertices * ((normals ? 2 : 1) * sizeof(Float3) + sizeof(Colour) + (sides ? 2 : 1) * sizeof(float)) +
         triangles * sizeof(Triangle);
}

Result<Done> write_deviation_glb(const DeviationMap& map, std::ostream& out) {
  if (auto ok = check(map); !ok) return ok;
  const tinygltf::Model model = Document(map).made();
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, false, true);
  return Done{};
}

}  // namespace meshgauge::api
