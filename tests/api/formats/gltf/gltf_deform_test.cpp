#include "api/formats/gltf/gltf_deform.h"

#include <doctest/doctest.h>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {
namespace {

// A tetrahedron with further accessors, whose bytes are appended.
class Builder {
 public:
  std::size_t add(const std::string& type, int component_type, std::size_t count, const std::string& bytes,
                  bool normalized = false) {
    while (data_.size() % 4 != 0) data_ += '\0';
    document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", bytes.size()}});
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component_type},
                                     {"count", count},
                                     {"type", type},
                                     {"normalized", normalized}});
    data_ += bytes;
    document["buffers"][0]["byteLength"] = data_.size();
    return document["accessors"].size() - 1;
  }
  std::string file() const { return glb(document, data_); }

  json document = tetrahedron();

 private:
  std::string data_ = tetrahedron_data();
};

std::string floats(const std::vector<float>& values) {
  std::string out;
  for (const float value : values) out += raw(value);
  return out;
}

json& primitive(Builder& file) { return file.document["meshes"][0]["primitives"][0]; }

// Vertex i follows only joint i % 2; the mesh's node is far away, which must not matter.
Builder skinned() {
  Builder out;
  std::string joints;
  std::string weights;
  for (char i = 0; i < 4; ++i) {
    joints += std::string({static_cast<char>(i % 2), 0, 0, 0});
    weights += floats({1, 0, 0, 0});
  }
  primitive(out)["attributes"]["JOINTS_0"] = out.add("VEC4", 5121, 4, joints);
  primitive(out)["attributes"]["WEIGHTS_0"] = out.add("VEC4", 5126, 4, weights);
  out.document["skins"] = {{{"joints", {2, 3}}}};
  out.document["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {1000, 0, 0}}},
                           {{"children", {2, 3}}, {"translation", {0, 0, 10}}},
                           {{"translation", {1, 0, 0}}},
                           {{"scale", {2, 2, 2}}}};
  out.document["scenes"][0]["nodes"] = {0, 1};
  return out;
}

}  // namespace

TEST_CASE("skins: vertices follow their joints, and not the node of the mesh") {
  Builder file = skinned();
  const auto result = read(file.file(), "");
  REQUIRE(result.ok());
  CHECK(result->mesh.positions == std::vector<Vec3>{{1, 0, 10}, {2, 0, 10}, {1, 1, 10}, {0, 0, 12}});
  CHECK(result->notes.remarks == std::vector<std::string>{"meshes skinned to the pose that the file stores: 1"});
  std::vector<float> matrices(32, 0);
  for (const std::size_t i : {0U, 5U, 10U, 15U, 16U, 21U, 26U, 31U}) matrices[i] = 1;
  matrices[12] = -1;  // the inverse of the first joint's translation
  file.document["skins"][0]["inverseBindMatrices"] = file.add("MAT4", 5126, 2, floats(matrices));
  CHECK(mesh_of(file.file()).positions[0] == Vec3(0, 0, 10));
  CHECK(mesh_of(file.file()).positions[3] == Vec3(0, 0, 12));
}

TEST_CASE("skins: weights of integers, of several sets, and with a sum of 1 up to rounding") {
  Builder file = skinned();
  std::string halves;
  for (int i = 0; i < 4; ++i) halves += std::string({127, 127, 0, 0});  // 254 of 255
  std::string both;
  for (int i = 0; i < 4; ++i) both += std::string({0, 1, 0, 0});
  json& attributes = primitive(file)["attributes"];
  attributes["JOINTS_0"] = file.add("VEC4", 5121, 4, both);
  attributes["WEIGHTS_0"] = file.add("VEC4", 5121, 4, halves, true);
  CHECK((mesh_of(file.file()).positions[1] - Vec3(2, 0, 10)).norm() < 1e-12);
  std::string rest;
  for (int i = 0; i < 4; ++i) rest += floats({0.5F, 0, 0, 0});
  attributes["WEIGHTS_0"] = attributes["WEIGHTS_1"] = file.add("VEC4", 5126, 4, rest);
  attributes["JOINTS_1"] = file.add(
      "VEC4", 5123, 4, raw_all<std::uint16_t>(std::vector<int>{1, 9, 9, 9, 1, 9, 9, 9, 1, 9, 9, 9, 1, 9, 9, 9}));
  CHECK(mesh_of(file.file()).positions[1] == Vec3(2, 0, 10));
}

TEST_CASE("skins: defects are refused by name") {
  const auto refused_with = [](const std::string& pointer, const json& value) {
    Builder file = skinned();
    file.document[json::json_pointer(pointer)] = value;
    return refusal(file.file(), "");
  };
  const std::string attributes = "/meshes/0/primitives/0/attributes";
  CHECK(contains(
      refused_with("/accessors/3", {{"componentType", 5120}, {"count", 4}, {"type", "VEC4"}, {"normalized", true}}),
      "WEIGHTS must be of type VEC4 and of float or normalized unsigned components"));
  CHECK(contains(refused_with("/nodes/0/skin", 4), "skins[4] of 'a': does not exist"));
  CHECK(contains(refused_with("/skins/0/joints", {2}), "names joint 1, but the skin has 1"));
  CHECK(contains(refused_with("/skins/0/joints", {2, 9}), "nodes[9] of 'a': does not exist"));
  CHECK(contains(refused_with("/skins/0/inverseBindMatrices", 0), "must be of type MAT4"));
  CHECK(contains(refused_with(attributes + "/JOINTS_4", 2),
                 "JOINTS_4 of 'a': more than 16 joints a vertex are not supported"));
  CHECK(contains(refused_with(attributes + "/JOINTS_0", 0), "JOINTS must be of type VEC4"));
  CHECK(contains(refused_with(attributes + "/WEIGHTS_1", 3), "needs JOINTS_1 and WEIGHTS_1"));
  CHECK(contains(refused_with(attributes, {{"POSITION", 0}}), "needs JOINTS_0 and WEIGHTS_0"));
  CHECK(contains(refused_with("/nodes/0/extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {}}}}}), "of 'a'"));
  Builder file = skinned();
  json& weights = primitive(file)["attributes"]["WEIGHTS_0"];
  weights = file.add("VEC4", 5126, 4, floats(std::vector<float>(16, 0.5F)));
  CHECK(contains(refusal(file.file(), ""), "the weights of vertex 0 do not add up to 1"));
  weights = file.add("VEC4", 5126, 4, floats(std::vector<float>(16, 0)));
  CHECK(contains(refusal(file.file(), ""), "the weights of vertex 0 do not add up to 1"));
  weights = file.add("VEC4", 5126, 4, floats(std::vector<float>(16, -1)));
  CHECK(contains(refusal(file.file(), ""), "vertex 0 has a negative weight"));
  Builder cycle = skinned();
  cycle.document["scenes"][0]["nodes"] = {0};
  cycle.document["nodes"][2]["children"] = {1};
  CHECK(contains(refusal(cycle.file(), ""), "in a cycle of nodes"));
}

TEST_CASE("skins and morph targets: the remarks count meshes, not placements") {
  Builder file = skinned();
  primitive(file)["targets"] = {{{"POSITION", 0}}};
  file.document["nodes"].push_back(file.document["nodes"][0]);
  file.document["scenes"][0]["nodes"].push_back(4);
  CHECK(read(file.file(), "")->notes.remarks ==
        std::vector<std::string>{"meshes skinned to the pose that the file stores: 1",
                                 "meshes with morph targets, taken at their default weights: 1"});
}

TEST_CASE("morph targets: at the weights of the mesh, or of the node, sparse ones as well") {
  Builder file;
  const std::size_t up = file.add("VEC3", 5126, 4, floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}));
  const std::size_t places = file.document["bufferViews"].size();
  file.add("SCALAR", 5123, 1, raw(std::uint16_t{3}));
  file.add("VEC3", 5126, 1, floats({8, 0, 0}));
  file.document["accessors"].push_back({{"componentType", 5126},
                                        {"count", 4},
                                        {"type", "VEC3"},
                                        {"sparse",
                                         {{"count", 1},
                                          {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                          {"values", {{"bufferView", places + 1}}}}}});
  primitive(file)["targets"] = {
      {{"POSITION", up}}, {{"POSITION", file.document["accessors"].size() - 1}}, {{"NORMAL", 0}}};
  CHECK(mesh_of(file.file()).positions[3] == Vec3(0, 0, 1));
  file.document["meshes"][0]["weights"] = {0.5, 0, 1};
  CHECK(mesh_of(file.file()).positions[3] == Vec3(0, 0, 1.5));
  file.document["nodes"][0]["weights"] = {2, 0.25};
  const auto result = read(file.file(), "");
  REQUIRE(result.ok());
  CHECK(result->mesh.positions == std::vector<Vec3>{{0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {2, 0, 3}});
  CHECK(result->notes.remarks ==
        std::vector<std::string>{"meshes with morph targets, taken at their default weights: 1"});
  primitive(file)["targets"] = {{{"POSITION", up}}};
  file.document["accessors"][up]["count"] = 3;
  CHECK(contains(refusal(file.file(), ""), "targets[0] of 'a': moves 3 of 4 vertices"));
}

TEST_CASE("morph targets: many targets with one accessor") {
  Builder file;
  primitive(file)["targets"] = json::array();
  file.document["meshes"][0]["weights"] = json::array();
  for (int i = 0; i < 1000; ++i) {
    primitive(file)["targets"].push_back({{"POSITION", 0}});
    file.document["meshes"][0]["weights"].push_back(1);
  }
  CHECK(mesh_of(file.file()).positions[1] == Vec3(1001, 0, 0));
}

TEST_CASE("instancing: translations, rotations and scales, under the node") {
  Builder file;
  json& attributes = file.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  file.document["nodes"][0]["translation"] = {0, 0, 5};
  attributes["TRANSLATION"] = file.add("VEC3", 5126, 2, floats({0, 0, 0, 10, 0, 0}));
  attributes["SCALE"] = file.add("VEC3", 5126, 2, floats({1, 1, 1, 2, 2, 2}));
  const auto result = read(file.file(), "");
  REQUIRE(result.ok());
  CHECK(result->mesh.positions.size() == 8);
  CHECK(result->mesh.positions[1] == Vec3(1, 0, 5));
  CHECK(result->mesh.positions[5] == Vec3(12, 0, 5));
  CHECK(result->notes.remarks == std::vector<std::string>{"instances by EXT_mesh_gpu_instancing: 2"});
  attributes["ROTATION"] =
      file.add("VEC4", 5122, 2, raw_all<std::int16_t>(std::vector<int>{0, 0, 0, 32767, 0, 0, 32767, 32767}), true);
  CHECK((mesh_of(file.file()).positions[5] - Vec3(10, 2, 5)).norm() < 1e-12);
  attributes["ROTATION"] = file.add("VEC4", 5123, 2, std::string(16, '\1'), true);
  CHECK(contains(refusal(file.file(), ""), "normalized signed components; it has 4 normalized components of"));
  attributes["ROTATION"] = file.add("VEC4", 5126, 2, floats(std::vector<float>(8, 0)));
  CHECK(contains(refusal(file.file(), ""), "instance 0 has a quaternion of length zero or too large"));
  attributes["ROTATION"] = file.add("VEC4", 5126, 1, floats({0, 0, 0, 1}));
  CHECK(contains(refusal(file.file(), ""), "nodes[0].extensions.EXT_mesh_gpu_instancing of 'a': its attributes"));
  file.document["extensionsUsed"] = {"KHR_mesh_quantization"};  // for vertices only
  for (const char* name : {"TRANSLATION", "SCALE"}) {
    const json floats_before = attributes[name];
    attributes[name] = file.add("VEC3", 5122, 2, std::string(12, '\1'));
    CHECK(contains(refusal(file.file(), ""), name + std::string(" must be of type VEC3 and of float components")));
    attributes[name] = floats_before;
  }
}

TEST_CASE("instancing: without a transform the mesh appears once, an empty attribute counts as present") {
  Builder file;
  json& attributes = file.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["_ID"] = file.add("SCALAR", 5126, 3, floats({1, 2, 3}));
  CHECK(mesh_of(file.file()).positions.size() == 4);
  attributes["TRANSLATION"] = file.add("VEC3", 5126, 2, floats({0, 0, 0, 10, 0, 0}));
  attributes["SCALE"] = file.add("VEC3", 5126, 1, floats({1, 1, 1}));
  file.document["accessors"].back()["count"] = 0;
  CHECK_FALSE(read(file.file(), "").ok());
}

TEST_CASE("instancing: a count beyond memory is refused before it is read") {
  Builder file;
  file.document["accessors"].push_back({{"componentType", 5126}, {"count", 1'000'001}, {"type", "VEC3"}});
  file.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      file.document["accessors"].size() - 1;
  CHECK(contains(refusal(file.file(), ""), "more instances than the limit of 1000000"));
}

TEST_CASE("instancing: the limits hold over all instances, also of empty meshes") {
  Builder file;
  json& attributes = file.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = file.add("VEC3", 5126, 100, floats(std::vector<float>(300, 1)));
  ReadLimits limits;
  limits.max_triangles = 399;
  CHECK(contains(read(file.file(), "", limits).error().message, "more triangles than the limit of 399"));
  limits.max_triangles = 400;
  CHECK(read(file.file(), "", limits).ok());
  primitive(file)["mode"] = 0;
  limits.max_triangles = 99;
  CHECK(contains(read(file.file(), "", limits).error().message, "more instances than the limit of 99"));
}

TEST_CASE("sparse accessors: indices without a bufferView of their own") {
  Builder file;
  const std::size_t places = file.document["bufferViews"].size();
  file.add("SCALAR", 5123, 2, raw_all<std::uint16_t>(std::vector<int>{1, 2}));
  file.document["accessors"].push_back({{"componentType", 5123},
                                        {"count", 3},
                                        {"type", "SCALAR"},
                                        {"sparse",
                                         {{"count", 2},
                                          {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                          {"values", {{"bufferView", places}}}}}});
  primitive(file)["indices"] = file.document["accessors"].size() - 1;
  CHECK(mesh_of(file.file()).triangles == std::vector<Triangle>{{0, 1, 2}});
}

}  // namespace meshgauge::api::test
