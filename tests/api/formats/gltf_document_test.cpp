#include "api/formats/gltf_document.h"

#include <doctest/doctest.h>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {

TEST_CASE("gltf: members of a wrong type or range are refused by their path") {
  CHECK(contains(refused("/accessors/1/count", 12.5), "accessors[1].count of 'a': expected an integer"));
  CHECK(contains(refused("/accessors/1/count", -1), "accessors[1].count of 'a': expected an integer"));
  CHECK(contains(refused("/accessors/1/count", "12"), "accessors[1].count of 'a': expected an integer"));
  CHECK(
      contains(refused("/accessors/1/bufferView", 4294967296), "accessors[1].bufferView of 'a': expected an integer"));
  CHECK(contains(refused("/nodes/0/mesh", 4294967296), "nodes[0].mesh of 'a': expected an integer"));
  CHECK(contains(refused("/nodes/0/mesh", nullptr), "nodes[0].mesh of 'a': expected an integer"));
  CHECK(contains(refused("/nodes/0/matrix", json::array({1, 2})),
                 "nodes[0].matrix of 'a': expected an array of 16 numbers"));
  CHECK(contains(refused("/nodes/0/scale", {nullptr, 1, 1}), "nodes[0].scale of 'a': expected an array of 3 numbers"));
  CHECK(contains(refused("/nodes/0/rotation", {0, 0, 0, 0}), "nodes[0].rotation of 'a': a quaternion without"));
  CHECK(contains(refused("/nodes/0/matrix", std::vector<int>(16, 1)), "nodes[0].matrix of 'a': the last row"));
  CHECK(contains(refused("/nodes/0/children", 1), "nodes[0].children of 'a': expected an array"));
  CHECK(contains(refused("/nodes/0/children", {0.5}), "nodes[0].children[0] of 'a': expected an integer"));
  CHECK(contains(refused("/nodes/0", 1), "nodes[0] of 'a': expected an object"));
  CHECK(contains(refused("/meshes", 1), "meshes of 'a': expected an array"));
  CHECK(contains(refused("/accessors/0/type", 3), "accessors[0].type of 'a': expected a string"));
  CHECK(contains(refused("/accessors/0/normalized", 1), "accessors[0].normalized of 'a': expected true or false"));
  CHECK(contains(refused("/extensionsUsed", {1}), "extensionsUsed of 'a': expected an array of strings"));
  CHECK(contains(refused_without("/accessors/0", "type"), "accessors[0].type of 'a': missing"));
  CHECK(contains(refused_without("/meshes/0/primitives/0", "attributes"), "primitives[0].attributes of 'a': missing"));
  CHECK(contains(refused_without("", "asset"), "asset of 'a': missing"));
  json integers_as_floats = tetrahedron();
  integers_as_floats["accessors"][1]["count"] = 12.0;
  CHECK(mesh_of(glb(integers_as_floats)).triangles.size() == 4);
}

TEST_CASE("gltf: extensions that hold the geometry are refused by name, others pass") {
  const auto message = refused("/extensionsRequired", {"KHR_materials_unlit", "ABC_other"});
  CHECK(contains(message, "the extension 'ABC_other' is not supported"));
  CHECK(refused("/extensionsRequired", {"KHR_materials_unlit", "KHR_texture_transform"}).empty());
  const json draco = {{"KHR_draco_mesh_compression", {{"bufferView", 0}}}};
  CHECK(contains(refused("/meshes/0/primitives/0/extensions", draco), "KHR_draco_mesh_compression is not supported"));
  CHECK(contains(refused("/nodes/0/extensions", {{"EXT_mesh_gpu_instancing", 1}}), "nodes[0] of 'a'"));
  CHECK(contains(refused("/asset/version", "1.0"), "glTF version '1.0' is not supported"));
}

TEST_CASE("gltf: nothing outside the file is opened") {
  CHECK(contains(refused("/buffers/0/uri", "../../../../../etc/passwd"), "'../../../../../etc/passwd' has '..'"));
  CHECK(contains(refused("/buffers/0/uri", "/etc/passwd"), "buffers[0].uri of 'a': '/etc/passwd' is absolute"));
  for (const std::string uri : {"http://127.0.0.1:9/a.bin", "file:///etc/passwd"}) {
    CHECK(contains(refused("/buffers/0/uri", uri), "has a scheme, and nothing is fetched"));
  }
  CHECK(contains(refused("/buffers/0/uri", "a.bin"), "names the file 'a.bin', which did not come with it"));
  CHECK(contains(refused("/buffers/0/uri", "data:application/octet-stream;base64,AA!AA"), "but there are"));
  CHECK(contains(refused("/buffers/0/uri", "data:text/html,abc"), "the data URI is not base64"));
  CHECK(refused("/images", json::array({{{"uri", "/etc/passwd"}}})).empty());  // images are not looked at
}

TEST_CASE("gltf: JSON that is deep, long or broken is refused") {
  const std::string deep = R"({"asset":{"version":"2.0"},"extras":)" + std::string(200'000, '[');
  CHECK(contains(refusal(deep, "m.gltf"), "nested deeper than 64"));
  CHECK(contains(refusal(container(chunk("JSON", deep, ' ')), ""), "nested deeper than 64"));
  std::string many = R"({"nodes":[{})";
  for (int i = 0; i < 100'000; ++i) many += ",{}";
  CHECK(contains(refusal(many + "]}", "m.gltf"), "too many values"));
  json in_string = tetrahedron();
  in_string["asset"]["generator"] = std::string(100, '[') + "\\\"{{{{";
  CHECK(mesh_of(glb(in_string)).triangles.size() == 4);
  CHECK(contains(refusal(R"({"asset": )", "m.gltf"), "not valid JSON"));
  CHECK(contains(refusal(R"({"asset": "unended)", "m.gltf"), "not valid JSON"));
  CHECK(contains(refusal(R"({"scene": 1e999})", "m.gltf"), "beyond the range of double"));
  CHECK(contains(refusal("[1]", "m.gltf"), "the glTF of 'a': expected an object"));
  CHECK(contains(refusal("{\"asset\": \"\xFF\"}", "m.gltf"), "not valid JSON"));
}

}  // namespace meshgauge::api::test
