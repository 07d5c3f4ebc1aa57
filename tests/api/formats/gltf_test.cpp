#include "api/formats/gltf.h"

#include <doctest/doctest.h>

#include <limits>

#include <nlohmann/json.hpp>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

using nlohmann::json;

constexpr std::array kIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

template <class T>
std::string raw_all(std::span<const int> values) {
  std::string out;
  for (const int value : values) out += raw(static_cast<T>(value));
  return out;
}

// A tetrahedron: four vertices of float (bytes 0 to 47), twelve indices of 16 bits (48 to 71).
std::string tetrahedron_data() {
  std::string data;
  for (const float c : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F}) data += raw(c);
  return data + raw_all<std::uint16_t>(kIndices);
}

json tetrahedron() {
  return json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": 72}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]})");
}

std::string chunk(const std::string& type, std::string content, char padding) {
  while (content.size() % 4 != 0) content += padding;
  return raw(static_cast<std::uint32_t>(content.size())) + type + content;
}

std::string container(const std::string& chunks, std::uint32_t version = 2) {
  return "glTF" + raw(version) + raw(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

std::string glb(const json& document, const std::string& data = tetrahedron_data()) {
  return container(chunk("JSON", document.dump(), ' ') + chunk(std::string("BIN\0", 4), data, '\0'));
}

std::string base64(const std::string& data) {
  const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < data.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8U | (i + k < data.size() ? static_cast<unsigned char>(data[i + k]) : 0U);
    }
    for (unsigned k = 0; k < 4; ++k) out += i + k > data.size() ? '=' : letters[bits >> (18 - 6 * k) & 63U];
  }
  return out;
}

Mesh mesh_of(const std::string& file) {
  auto result = read(file, "");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(result->mesh);
}

// The refusal of the tetrahedron with one member replaced.
std::string refused(const std::string& pointer, const json& value) {
  json document = tetrahedron();
  document[json::json_pointer(pointer)] = value;
  return refusal(glb(document), "m.glb");
}

std::string refused_without(const std::string& pointer, const std::string& member) {
  json document = tetrahedron();
  document[json::json_pointer(pointer)].erase(member);
  return refusal(glb(document), "m.glb");
}

// The four vertices of the tetrahedron under a node.
std::vector<Vec3> placed(const json& node) {
  json document = tetrahedron();
  document["nodes"][0].update(node);
  return mesh_of(glb(document)).positions;
}

bool near(const Vec3& a, const Vec3& b) { return (a - b).norm() <= 1e-15; }

}  // namespace

TEST_CASE("gltf: a GLB and a glTF with a data URI give the same mesh") {
  const auto binary = read(glb(tetrahedron()), "m.glb");
  REQUIRE(binary.ok());
  CHECK(binary->format == Format::glb);
  CHECK(binary->mesh.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  CHECK(binary->mesh.triangles == std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
  json document = tetrahedron();
  document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(tetrahedron_data());
  for (const std::string& text : {document.dump(), "\xEF\xBB\xBF" + document.dump(2) + "\n"}) {
    const auto embedded = read(text, "m.gltf");
    REQUIRE(embedded.ok());
    CHECK(embedded->format == Format::gltf);
    CHECK(embedded->mesh.positions == binary->mesh.positions);
    CHECK(embedded->mesh.triangles == binary->mesh.triangles);
  }
  CHECK(mesh_of(glb(document, "unused")).triangles == binary->mesh.triangles);
}

TEST_CASE("gltf: node transforms, alone and nested") {
  CHECK(placed({{"translation", {1, 2, 3}}})[1] == Vec3(2, 2, 3));
  CHECK(placed({{"scale", {2, 3, -4}}})[3] == Vec3(0, 0, -4));
  CHECK(near(placed({{"rotation", {0, 0, 0.7071067811865476, 0.7071067811865476}}})[1], Vec3(0, 1, 0)));
  CHECK(near(placed({{"rotation", {0, 0, 7, 7}}})[1], Vec3(0, 1, 0)));
  const json all = {{"translation", {10, 0, 0}}, {"rotation", {0, 0, 1, 1}}, {"scale", {2, 1, 1}}};
  CHECK(near(placed(all)[1], Vec3(10, 2, 0)));
  CHECK(placed({{"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}})[1] == Vec3(5, 7, 7));

  json document = tetrahedron();
  document["nodes"] = {{{"children", {1}}, {"translation", {0, 0, 5}}},
                       {{"children", {2}}, {"scale", {2, 2, 2}}},
                       {{"mesh", 0}, {"translation", {1, 0, 0}}}};
  CHECK(mesh_of(glb(document)).positions[3] == Vec3(2, 0, 7));
  document["nodes"][0]["children"] = {1, 3};
  document["nodes"].push_back({{"mesh", 0}, {"scale", {-1, 1, 1}}});
  const Mesh both = mesh_of(glb(document));
  CHECK(both.triangles.size() == 8);
  CHECK(both.positions.size() == 8);
  CHECK(both.positions[5] == Vec3(-1, 0, 5));
}

TEST_CASE("gltf: the default scene, else the first, else all root nodes") {
  json document = tetrahedron();
  document["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {9, 0, 0}}}, {{"children", {1}}}};
  document["scenes"] = {{{"nodes", {0}}}, {{"nodes", {2}}}};
  CHECK(mesh_of(glb(document)).positions[0] == Vec3(0, 0, 0));
  document["scene"] = 1;
  CHECK(mesh_of(glb(document)).positions[0] == Vec3(9, 0, 0));
  document.erase("scene");
  CHECK(mesh_of(glb(document)).triangles.size() == 4);
  document.erase("scenes");
  CHECK(mesh_of(glb(document)).triangles.size() == 8);
  document["scene"] = 2;
  CHECK(contains(refusal(glb(document), "m.glb"), "scene of 'a': 2 does not exist"));
}

TEST_CASE("gltf: every mode of triangles; points and lines are counted") {
  json document = tetrahedron();
  json& primitives = document["meshes"][0]["primitives"];
  primitives[0] = {{"attributes", {{"POSITION", 0}}}, {"mode", 5}};
  CHECK(mesh_of(glb(document)).triangles == std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}});
  primitives[0]["mode"] = 6;
  CHECK(mesh_of(glb(document)).triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
  primitives.push_back(primitives[0]);
  primitives[1]["indices"] = 1;
  const Mesh shared = mesh_of(glb(document));
  CHECK(shared.positions.size() == 4);
  CHECK(shared.triangles.size() == 2 + 10);
  for (const int mode : {0, 1, 2, 3}) primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  CHECK(read(glb(document), "")->notes.skipped_primitives == 4);
  primitives = json::array({primitives[2]});
  CHECK(code(glb(document), "") == ErrorCode::empty_mesh);
  primitives[0]["mode"] = 7;
  CHECK(contains(refusal(glb(document), ""), "mode 7 does not exist"));
  primitives[0]["mode"] = 4;
  CHECK(contains(refusal(glb(document), ""), "4 corners are no whole number of triangles"));
}

TEST_CASE("gltf: indices of 8, 16 and 32 bits; strides") {
  const Mesh expected = mesh_of(glb(tetrahedron()));
  const std::string vertices = tetrahedron_data().substr(0, 48);
  std::string data = vertices + raw_all<std::uint8_t>(kIndices);
  json document = tetrahedron();
  document["buffers"][0]["byteLength"] = 60;
  document["bufferViews"][1]["byteLength"] = 12;
  document["accessors"][1]["componentType"] = 5121;
  CHECK(mesh_of(glb(document, data)).triangles == expected.triangles);
  data = vertices + raw_all<std::uint32_t>(kIndices);
  document["buffers"][0]["byteLength"] = 96;
  document["bufferViews"][1]["byteLength"] = 48;
  document["accessors"][1]["componentType"] = 5125;
  CHECK(mesh_of(glb(document, data)).triangles == expected.triangles);

  std::string spread;  // a normal after each vertex, and something before the first
  for (std::size_t i = 0; i < 4; ++i) spread += std::string(8, 'n') + data.substr(12 * i, 12);
  document["buffers"][0]["byteLength"] = 80;
  document["bufferViews"][0] = {{"buffer", 0}, {"byteLength", 80}, {"byteStride", 20}};
  document["accessors"][0]["byteOffset"] = 8;
  document["meshes"][0]["primitives"][0].erase("indices");
  document["meshes"][0]["primitives"][0]["mode"] = 5;
  document["accessors"].erase(1);
  document["bufferViews"].erase(1);
  CHECK(mesh_of(glb(document, spread)).positions == expected.positions);
  document["accessors"][0]["byteOffset"] = 12;
  CHECK(contains(refusal(glb(document, spread), ""), "4 elements reach beyond bufferViews[0]"));
}

TEST_CASE("gltf: sparse accessors, over data and over nothing") {
  json document = tetrahedron();
  // Vertex 2 (the index at byte 50) takes the place of vertex 1 (the value at byte 12).
  document["accessors"][0]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", 1}, {"byteOffset", 2}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", 0}, {"byteOffset", 12}}}};
  CHECK(mesh_of(glb(document)).positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 1}});
  document["accessors"][0].erase("bufferView");
  CHECK(mesh_of(glb(document)).positions == std::vector<Vec3>{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}});
  json& sparse = document["accessors"][0]["sparse"];
  sparse["count"] = 5;
  CHECK(contains(refusal(glb(document), ""), "more sparse elements than elements"));
  sparse["count"] = 1;
  sparse["values"]["byteOffset"] = 40;
  CHECK(contains(refusal(glb(document), ""), "1 elements reach beyond bufferViews[0]"));
  sparse["values"]["byteOffset"] = 0;
  sparse["indices"]["bufferView"] = 0;
  sparse["indices"]["byteOffset"] = 14;  // half of the float 1
  CHECK(contains(refusal(glb(document), ""), "sparse index 16256 is out of range"));
  sparse["indices"]["componentType"] = 5126;
  CHECK(contains(refusal(glb(document), ""), "sparse indices must be unsigned integers"));
}

TEST_CASE("gltf: quantized positions by KHR_mesh_quantization") {
  const auto data = raw_all<std::int16_t>(std::array{0, 0, 0, 32767, 0, 0, 0, -32768, 0});
  json document = tetrahedron();
  document["buffers"][0]["byteLength"] = 18;
  document["bufferViews"] = {{{"buffer", 0}, {"byteLength", 18}}};
  document["accessors"] = {
      {{"bufferView", 0}, {"componentType", 5122}, {"count", 3}, {"type", "VEC3"}, {"normalized", true}}};
  document["meshes"][0]["primitives"][0].erase("indices");
  CHECK(contains(refusal(glb(document, data), ""), "with KHR_mesh_quantization"));
  document["extensionsUsed"] = {"KHR_mesh_quantization"};
  CHECK(mesh_of(glb(document, data)).positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}});
  document["extensionsRequired"] = {"KHR_mesh_quantization"};
  document["accessors"][0].erase("normalized");
  CHECK(mesh_of(glb(document, data)).positions == std::vector<Vec3>{{0, 0, 0}, {32767, 0, 0}, {0, -32768, 0}});
}

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

TEST_CASE("gltf: references that lead nowhere are refused") {
  CHECK(contains(refused("/scenes/0/nodes", {7}), "the scene of 'a': nodes[7] does not exist"));
  CHECK(contains(refused("/nodes/0/children", {7}), "nodes[0] of 'a': nodes[7] does not exist"));
  CHECK(contains(refused("/nodes/0/mesh", 3), "meshes[3] of 'a': does not exist"));
  CHECK(contains(refused("/meshes/0/primitives/0/attributes/POSITION", 5), "accessors[5] of 'a': does not exist"));
  CHECK(contains(refused("/meshes/0/primitives/0/indices", 5), "out of bounds"));
  CHECK(contains(refused("/accessors/0/bufferView", 5), "accessors[0] of 'a': bufferViews[5] does not exist"));
  CHECK(contains(refused("/bufferViews/0/buffer", 5), "names buffer 5, which does not exist"));
  CHECK(contains(refused_without("/meshes/0/primitives/0/attributes", "POSITION"), "no attribute POSITION"));
}

TEST_CASE("gltf: offsets, lengths and counts are checked without overflow") {
  const double huge = 0x1p53;
  CHECK(contains(refused("/bufferViews/0/byteLength", 73), "reaches beyond its buffer of 72 bytes"));
  CHECK(contains(refused("/bufferViews/0/byteOffset", huge), "reaches beyond its buffer"));
  CHECK(contains(refused("/accessors/0/byteOffset", huge), "reach beyond bufferViews[0]"));
  CHECK(contains(refused("/accessors/1/count", huge), "reach beyond bufferViews[1]"));
  CHECK(contains(refused("/accessors/1/count", 13), "13 elements reach beyond bufferViews[1]"));
  CHECK(contains(refused("/accessors/0/count", 357'913'942), "vertices"));  // times 12 is 2^32 + 8
  CHECK(contains(refused("/bufferViews/0/byteStride", 8), "less than an element of 12 bytes"));
  CHECK(contains(refused("/bufferViews/0/byteStride", 16), "4 elements reach beyond bufferViews[0]"));
  CHECK(contains(refused("/buffers/0/byteLength", 73), "byteLength is 73, but there are 72 bytes"));
  CHECK(contains(refused("/accessors/0/type", "VEC2"), "POSITION must be of type VEC3"));
  CHECK(contains(refused("/accessors/0/componentType", 5123), "POSITION must be of float"));
  CHECK(contains(refused("/accessors/1/componentType", 5126), "indices must be of type SCALAR"));
  json zeros = tetrahedron();
  zeros["accessors"][0].erase("bufferView");
  CHECK(mesh_of(glb(zeros)).positions[3] == Vec3(0, 0, 0));
  zeros["accessors"][0]["count"] = 100'000'000;
  CHECK(contains(refusal(glb(zeros), ""), "100000000 elements without a bufferView"));
}

TEST_CASE("gltf: indices out of range and coordinates that are not finite are refused") {
  std::string data = tetrahedron_data();
  data.replace(70, 2, raw(std::uint16_t{4}));
  CHECK(code(glb(tetrahedron(), data), "") == ErrorCode::index_out_of_range);
  CHECK(contains(refusal(glb(tetrahedron(), data), ""), "index 4 at place 11, but there are 4 vertices"));
  data = tetrahedron_data();
  data.replace(44, 4, raw(std::numeric_limits<float>::infinity()));
  CHECK(code(glb(tetrahedron(), data), "") == ErrorCode::non_finite_vertex);
  json document = tetrahedron();
  document["nodes"][0]["scale"] = {1e308, 1, 1};
  CHECK(code(glb(document), "") == ErrorCode::coordinate_too_large);
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
  for (const std::string uri :
       {"../../../../../etc/passwd", "/etc/passwd", "http://127.0.0.1:9/a.bin", "file:///etc/passwd"}) {
    const std::string message = refused("/buffers/0/uri", uri);
    CHECK(contains(message, "buffers[0].uri of 'a': the external buffer '" + uri + "' is not available"));
  }
  CHECK(contains(refused("/buffers/0/uri", "data:application/octet-stream;base64,AA!AA"), "but there are"));
  CHECK(contains(refused("/buffers/0/uri", "data:text/html,abc"), "the data URI is not base64"));
  CHECK(refused("/images", json::array({{{"uri", "/etc/passwd"}}})).empty());  // images are not looked at
}

TEST_CASE("gltf: cycles, ladders and long chains of nodes end") {
  json document = tetrahedron();
  document["nodes"] = {{{"children", {1}}}, {{"children", {0}}, {"mesh", 0}}};
  CHECK(contains(refusal(glb(document), ""), "used twice: several parents, or a cycle"));
  json ladder = json::array();
  for (int i = 1; i <= 40; ++i) ladder.push_back({{"children", {i, i}}});
  ladder.push_back({{"mesh", 0}});
  document["nodes"] = ladder;
  CHECK(contains(refusal(glb(document), ""), "used twice"));
  json chain = json::array();
  for (int i = 1; i <= 100'000; ++i) chain.push_back({{"children", {i}}});
  chain.push_back({{"mesh", 0}});
  document["nodes"] = chain;
  CHECK(mesh_of(glb(document)).triangles.size() == 4);
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

TEST_CASE("gltf: malformed containers are refused with their byte") {
  const std::string text = tetrahedron().dump();
  const std::string whole = glb(tetrahedron());
  const std::string json_chunk = chunk("JSON", text, ' ');
  const std::string bin_chunk = chunk(std::string("BIN\0", 4), tetrahedron_data(), '\0');
  CHECK(contains(refusal(container(json_chunk + bin_chunk, 1), ""), "byte 4 of 'a': GLB: version 1 is not supported"));
  CHECK(contains(refusal(whole.substr(0, whole.size() - 1), ""), "byte 8 of 'a': GLB: truncated"));
  CHECK(contains(refusal(whole + "x", ""), "left-over bytes"));
  CHECK(contains(refusal(container(bin_chunk + json_chunk), ""), "byte 12 of 'a': GLB: the first chunk"));
  CHECK(contains(refusal(container(json_chunk + json_chunk), ""), "the first chunk, and no other, must be JSON"));
  CHECK(contains(refusal(container(json_chunk + bin_chunk + bin_chunk), ""), "a BIN chunk that is not the second"));
  CHECK(contains(refusal(container(json_chunk + "abc"), ""), "truncated chunk header"));
  CHECK(contains(refusal(container(json_chunk), ""), "neither a URI nor a BIN chunk"));
  CHECK(contains(refusal(container(""), ""), "no JSON chunk"));
  std::string long_chunk = whole;
  long_chunk.replace(12, 4, raw(std::uint32_t{0xFFFFFFFC}));
  CHECK(contains(refusal(long_chunk, ""), "truncated: a chunk of 4294967292 bytes"));
  CHECK(mesh_of(container(json_chunk + bin_chunk + chunk("ABCD", "1234", ' '))).triangles.size() == 4);
  CHECK(mesh_of(container(chunk("JSON", text, '\0') + bin_chunk)).triangles.size() == 4);
  json two = tetrahedron();
  two["buffers"].push_back({{"byteLength", 72}});
  CHECK(contains(refusal(glb(two), ""), "buffers[1] of 'a': no data"));
}

TEST_CASE("gltf: the limits of vertices and triangles hold over all instances") {
  json document = tetrahedron();
  for (int i = 1; i < 10; ++i) {
    document["nodes"].push_back({{"mesh", 0}});
    document["scenes"][0]["nodes"].push_back(i);
  }
  ReadLimits limits;
  limits.max_triangles = 40;
  limits.max_vertices = 40;
  CHECK(read(glb(document), "", limits).ok());
  limits.max_triangles = 39;
  auto triangles = read(glb(document), "", limits);
  REQUIRE(!triangles.ok());
  CHECK(triangles.error().code == ErrorCode::too_large);
  limits = {};
  limits.max_vertices = 39;
  auto vertices = read(glb(document), "", limits);
  REQUIRE(!vertices.ok());
  CHECK(vertices.error().code == ErrorCode::too_large);
}

}  // namespace meshgauge::api::test
