#include "api/formats/gltf/gltf_document.h"

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
  CHECK(contains(refused("/nodes/0/rotation", {0, 0, 0, 0}), "nodes[0].rotation of 'a': a quaternion of length zero"));
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

TEST_CASE("gltf: required extensions without effect on the surface pass, others are refused by name") {
  for (const char* name : {"KHR_materials_unlit", "KHR_texture_transform", "EXT_texture_webp", "KHR_lights_punctual",
                           "KHR_technique_webgl", "KHR_techniques_webgl", "KHR_node_visibility",
                           "KHR_animation_pointer", "KHR_xmp_json_ld", "FB_ngon_encoding"}) {
    CHECK(refused("/extensionsRequired", json::array({name})).empty());
  }
  for (const char* name : {"ABC_other", "CESIUM_RTC", "WEB3D_quantized_attributes", "KHR_mesh"}) {
    const std::string message = refused("/extensionsRequired", {"KHR_materials_unlit", name});
    CHECK(contains(message, std::string("extensionsRequired of 'a': the extension '") + name + "' is not supported"));
  }
  for (const std::string version : {"3.0", "0.8", "10.0", "20.0", "2"}) {
    CHECK(contains(refused("/asset/version", version),
                   "asset.version of 'a': glTF '" + version + "' is not supported; save the model as glTF 2.0"));
  }
  CHECK(contains(refused("/asset/version", 0.8), "glTF '0.8' is not supported"));
  CHECK(contains(refused("/asset/version", 2.0), "asset.version of 'a': expected a string"));
}

TEST_CASE("gltf: glTF 1.0 is named in its refusal") {
  const std::string name = "'a' is of glTF 1.0, which is not supported; save the model as glTF 2.0";
  CHECK(refused("/asset/version", "1.0") == name);
  CHECK(refused("/asset/version", "1.1") == name);
  CHECK(refused("/asset/version", 1) == name);
  const std::string maps = R"({"meshes": {"m": {}}, "nodes": {"n": {"meshes": ["m"]}}})";
  CHECK(refusal(maps, "m.gltf") == name);
  CHECK(code(maps, "m.gltf") == ErrorCode::unsupported_format);
  const std::string binary = "glTF" + raw(std::uint32_t{1}) + raw(std::uint32_t{26}) + raw(std::uint32_t{6}) +
                             raw(std::uint32_t{0}) + R"({"a":})";
  CHECK(refusal(binary, "m.glb") == name);
  CHECK(code(binary, "") == ErrorCode::unsupported_format);
}

TEST_CASE("gltf: nothing outside the file is opened") {
  CHECK(contains(refused("/buffers/0/uri", "../../../../../etc/passwd"), "'../../../../../etc/passwd' has '..'"));
  CHECK(contains(refused("/buffers/0/uri", "/etc/passwd"), "buffers[0].uri of 'a': '/etc/passwd' is absolute"));
  for (const std::string uri : {"http://127.0.0.1:9/a.bin", "file:///etc/passwd"}) {
    CHECK(contains(refused("/buffers/0/uri", uri), "has a scheme, and nothing is fetched"));
  }
  json cases = tetrahedron();
  cases["buffers"] = {{{"byteLength", 72}, {"uri", "A.bin"}}, {{"byteLength", 72}, {"uri", "a.bin"}}};
  CHECK(contains(refusal(cases.dump(), "m.gltf"),
                 "buffers[1].uri of 'a': 'a.bin' differs from 'A.bin' by letter case alone: rename one"));
  CHECK(contains(refused("/buffers/0/uri", "_rels/.rels"), "'_rels/.rels' is the name of a part that every 3MF has"));
  CHECK(contains(refused("/buffers/0/uri", "a.bin"), "names the file 'a.bin', which was not sent with it"));
  CHECK(contains(refused("/buffers/0/uri", "data:application/octet-stream;base64,AA!AA"), "but there are"));
  CHECK(contains(refused("/buffers/0/uri", "data:text/html,abc"), "the data URI is not base64"));
  CHECK(contains(refused("/buffers/0/uri", "data:base64"), "the data URI is not base64"));
  CHECK(refused("/images", json::array({{{"uri", "/etc/passwd"}}})).empty());  // images are not read
}

TEST_CASE("gltf: data URIs of any media type are read, and noted") {
  const std::string data = base64(tetrahedron_data());
  const auto embedded = [&](const std::string& start) {
    json document = tetrahedron();
    document["buffers"][0]["uri"] = start + data;
    return read(document.dump(), "m.gltf");
  };
  for (const char* start : {"data:application/octet-stream;base64,", "data:application/gltf-buffer;base64,"}) {
    REQUIRE(embedded(start).ok());
    CHECK(embedded(start)->notes.remarks.empty());
  }
  for (const char* start : {"data:;base64,", "data:text/plain;base64,", "data:model/gltf-buffer;charset=x;base64,"}) {
    const auto result = embedded(start);
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles.size() == 4);
    CHECK(result->notes.remarks ==
          std::vector<std::string>{"buffers in data URIs of another media type than a glTF allows: 1"});
  }
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
