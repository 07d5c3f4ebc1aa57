#include "api/formats/gltf/gltf_accessor.h"

#include <doctest/doctest.h>

#include <limits>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {

TEST_CASE("gltf: indices of 8, 16 and 32 bits, strides") {
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

namespace {

const std::string kOdd = "bufferViews with elements where glTF does not allow them (offset or byteStride): ";

// Three vertices of 16 bits, `stride` bytes apart, after `before` bytes; no indices.
std::string spread_out(std::size_t stride, std::size_t before, const json& said) {
  std::string data(before, 'b');
  for (const int vertex : {0, 1, 2}) {
    for (const int k : {0, 1, 2}) data += raw(static_cast<std::uint16_t>(vertex == k ? 9 : 0));
    data += std::string(stride - 6, 's');
  }
  json document = tetrahedron();
  document["extensionsRequired"] = {"KHR_mesh_quantization"};
  document["buffers"][0]["byteLength"] = data.size();
  document["bufferViews"] = {{{"buffer", 0}, {"byteLength", data.size()}}};
  if (!said.is_null()) document["bufferViews"][0]["byteStride"] = said;
  document["accessors"] = {
      {{"bufferView", 0}, {"byteOffset", before}, {"componentType", 5123}, {"count", 3}, {"type", "VEC3"}}};
  document["meshes"][0]["primitives"][0].erase("indices");
  return glb(document, data);
}

}  // namespace

TEST_CASE("gltf: strides and offsets of attributes that glTF does not allow are read, and noted") {
  struct Layout {
    std::size_t stride;
    std::size_t before;
    json said;
    bool odd;
  };
  const Layout layouts[] = {{6, 0, 6, true},   {6, 0, 0, true},     {6, 0, nullptr, false}, {7, 0, 7, true},
                            {8, 0, 8, false},  {8, 4, 8, false},    {8, 2, 8, true},        {6, 3, 6, true},
                            {10, 1, 10, true}, {256, 0, 256, true}, {252, 0, 252, false}};
  for (const Layout& layout : layouts) {
    CAPTURE(layout.said.dump());
    CAPTURE(layout.before);
    const auto result = read(spread_out(layout.stride, layout.before, layout.said), "m.glb");
    REQUIRE(result.ok());
    CHECK(result->mesh.positions == std::vector<Vec3>{{9, 0, 0}, {0, 9, 0}, {0, 0, 9}});
    CHECK(result->notes.remarks == (layout.odd ? std::vector{kOdd + "1"} : std::vector<std::string>{}));
  }
  for (const int stride : {1, 3, 5}) {
    CHECK(contains(refusal(spread_out(6, 0, stride), ""),
                   "bufferViews[0] has a byteStride of " + std::to_string(stride) + ", less than the 6 bytes"));
  }
  CHECK(contains(refusal(spread_out(6, 0, 7), ""), "3 elements reach beyond bufferViews[0] of 18 bytes"));
}

TEST_CASE("gltf: a view that only other attributes use may have any stride") {
  json document = tetrahedron();
  document["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 48}, {"byteStride", 3}});
  document["accessors"].push_back({{"bufferView", 2}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2;
  const auto result = read(glb(document), "m.glb");
  REQUIRE(result.ok());
  CHECK(result->notes.remarks.empty());
}

TEST_CASE("gltf: a byteStride of indices is read where it has one meaning, else refused") {
  const Mesh expected = mesh_of(glb(tetrahedron()));
  json document = tetrahedron();
  for (const int stride : {0, 2, 6, 12}) {  // those of 6 and 12 bytes do not fit: a triangle or two were meant
    document["bufferViews"][1]["byteStride"] = stride;
    const auto result = read(glb(document), "m.glb");
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles == expected.triangles);
    CHECK(result->notes.remarks == std::vector{kOdd + "1"});
  }
  document["accessors"][1]["count"] = 6;
  document["bufferViews"][1]["byteStride"] = 4;
  CHECK(contains(refusal(glb(document), ""),
                 "accessors[1] of 'a': bufferViews[1] has a byteStride of 4, which glTF allows for attributes alone: "
                 "elements of 2 bytes may lie side by side or that far apart; save the model without this byteStride"));
  document["bufferViews"][1]["byteStride"] = 1;
  CHECK(contains(refusal(glb(document), ""), "bufferViews[1] has a byteStride of 1, less than the 2 bytes"));
  document["bufferViews"][1].erase("byteStride");
  document["bufferViews"][1]["byteOffset"] = 47;
  document["accessors"][1]["byteOffset"] = 1;
  document["accessors"][1]["count"] = 6;
  CHECK(read(glb(document), "")->notes.remarks == std::vector{kOdd + "1"});
}

TEST_CASE("gltf: sparse accessors, with and without data below") {
  json document = tetrahedron();
  // Replaces vertex 2 (the index at byte 50) by vertex 1 (the value at byte 12).
  document["accessors"][0]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", 1}, {"byteOffset", 2}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", 0}, {"byteOffset", 12}}}};
  CHECK(mesh_of(glb(document)).positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 0, 1}});
  document["accessors"][0].erase("bufferView");
  CHECK(mesh_of(glb(document)).positions == std::vector<Vec3>{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}});
  json& sparse = document["accessors"][0]["sparse"];
  sparse["count"] = 5;
  CHECK(contains(refusal(glb(document), ""), "5 sparse elements, but only 4 elements"));
  sparse["count"] = 1;
  sparse["values"]["byteOffset"] = 40;
  CHECK(contains(refusal(glb(document), ""), "1 elements reach beyond bufferViews[0]"));
  sparse["values"]["byteOffset"] = 0;
  sparse["indices"]["bufferView"] = 0;
  sparse["indices"]["byteOffset"] = 14;  // half of the float 1
  CHECK(contains(refusal(glb(document), ""), "sparse index 16256 at place 0, but there are 4 elements"));
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

TEST_CASE("gltf: quantized positions of every type, normalised or not") {
  struct Type {
    int name;
    std::string bytes;  // the largest value, 0 and the least
    double most;
    double least;
  };
  const auto triple = [](auto most, auto least) { return raw(most) + raw(decltype(most){0}) + raw(least); };
  for (const Type& type : {Type{5120, triple(std::int8_t{127}, std::int8_t{-128}), 127, -128},
                           Type{5121, triple(std::uint8_t{255}, std::uint8_t{0}), 255, 0},
                           Type{5122, triple(std::int16_t{32767}, std::int16_t{-32768}), 32767, -32768},
                           Type{5123, triple(std::uint16_t{65535}, std::uint16_t{0}), 65535, 0}}) {
    CAPTURE(type.name);
    const std::string padded = type.bytes + std::string((4 - type.bytes.size() % 4) % 4, 'p');
    const std::string data = padded + padded + padded;
    json document = tetrahedron();
    document["extensionsRequired"] = {"KHR_mesh_quantization"};
    document["buffers"][0]["byteLength"] = data.size();
    document["bufferViews"] = {{{"buffer", 0}, {"byteLength", data.size()}, {"byteStride", data.size() / 3}}};
    document["accessors"] = {{{"bufferView", 0}, {"componentType", type.name}, {"count", 3}, {"type", "VEC3"}}};
    document["meshes"][0]["primitives"][0].erase("indices");
    CHECK(mesh_of(glb(document, data)).positions[2] == Vec3(type.most, 0, type.least));
    document["accessors"][0]["normalized"] = true;
    CHECK(mesh_of(glb(document, data)).positions[2] == Vec3(1, 0, type.least < 0 ? -1 : 0));
  }
}

TEST_CASE("gltf: offsets, lengths and counts are checked without overflow") {
  const double huge = 0x1p53;
  CHECK(contains(refused("/bufferViews/0/byteLength", 73), "reaches beyond its buffer of 72 bytes"));
  CHECK(contains(refused("/bufferViews/0/byteOffset", huge), "reaches beyond its buffer"));
  CHECK(contains(refused("/accessors/0/byteOffset", huge), "reach beyond bufferViews[0]"));
  CHECK(contains(refused("/accessors/1/count", huge), "reach beyond bufferViews[1]"));
  CHECK(contains(refused("/accessors/1/count", 13), "13 elements reach beyond bufferViews[1]"));
  CHECK(contains(refused("/accessors/0/count", 357'913'942), "vertices"));  // times 12 is 2^32 + 8
  CHECK(contains(refused("/bufferViews/0/byteStride", 8),
                 "bufferViews[0] has a byteStride of 8, less than the 12 bytes of an element"));
  CHECK(contains(refused("/bufferViews/0/byteStride", 16), "4 elements reach beyond bufferViews[0]"));
  CHECK(contains(refused("/buffers/0/byteLength", 73), "byteLength is 73, but there are 72 bytes"));
  CHECK(contains(refused("/accessors/0/type", "VEC2"), "POSITION must be of type VEC3"));
  CHECK(contains(refused("/accessors/0/componentType", 5123), "POSITION must be of type VEC3 and of float"));
  CHECK(contains(refused("/accessors/1/componentType", 5126),
                 "indices must be of type SCALAR and of unsigned integers; it has 1 components of componentType 5126"));
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

}  // namespace meshgauge::api::test
