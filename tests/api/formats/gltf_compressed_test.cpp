#include "tests/api/formats/gltf_compressed.h"

#include <doctest/doctest.h>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {
namespace {

const std::vector<float> kPositions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::vector<std::uint32_t> kTetrahedronCorners(kIndices.begin(), kIndices.end());

json document_of(const std::string& file) {
  std::uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, sizeof length);
  return json::parse(file.substr(20, length));
}

std::string data_of(const std::string& file) { return file.substr(file.find(std::string("BIN\0", 4)) + 4); }

// The refusal of a file with one member replaced.
std::string refused_in(const std::string& file, const std::string& pointer, const json& value) {
  json document = document_of(file);
  document[json::json_pointer(pointer)] = value;
  return refusal(glb(document, data_of(file)), "m.glb");
}

const std::string kDracoAt = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
const std::string kMeshoptAt = "/bufferViews/0/extensions/EXT_meshopt_compression";

// The beginning of a stream by edges: version 2.2, a mesh, and what it claims.
std::string claim(std::uint32_t vertices, std::uint32_t faces, char attribute_tables = 0) {
  const auto varint = [](std::uint32_t value) {
    std::string out;
    for (; value > 127; value >>= 7U) out += static_cast<char>(value | 128U);
    return out + static_cast<char>(value);
  };
  return std::string("DRACO\x02\x02\x01\x01\0\0\0", 12) + varint(vertices) + varint(faces) + attribute_tables +
         varint(faces) + varint(0) + std::string(40, '\0');
}

// Every triangle by the positions of its corners, the least first.
std::vector<std::vector<double>> triangles_of(const Mesh& mesh) {
  std::vector<std::vector<double>> out;
  for (const Triangle& triangle : mesh.triangles) {
    std::vector<std::vector<double>> corners;
    for (const std::uint32_t index : triangle) {
      corners.push_back({mesh.positions[index][0], mesh.positions[index][1], mesh.positions[index][2]});
    }
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    out.push_back(corners[0]);
    for (const auto& corner : {corners[1], corners[2]})
      out.back().insert(out.back().end(), corner.begin(), corner.end());
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace

TEST_CASE("draco: the triangles of both encodings") {
  const auto expected = triangles_of(mesh_of(glb(tetrahedron())));
  for (const int bits : {0, 11}) {
    for (const int speed : {0, 5, 10}) {
      const auto result = read(draco_glb(draco_stream(kPositions, kTetrahedronCorners, bits, speed)), "m.glb");
      REQUIRE(result.ok());
      CHECK(triangles_of(result->mesh) == expected);
      CHECK(result->notes.remarks == std::vector<std::string>{"primitives decoded from Draco: 1"});
    }
  }
}

TEST_CASE("draco: compressed data is read, even if optional and beside plain data") {
  const std::string file = draco_glb(draco_stream(kPositions, kTetrahedronCorners, 0, 5));
  json document = document_of(file);
  document.erase("extensionsRequired");
  const std::string data = data_of(file);
  document["buffers"].push_back(
      {{"byteLength", 72}, {"uri", "data:application/octet-stream;base64," + base64(std::string(72, '\0'))}});
  document["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 72}});
  document["accessors"][0]["bufferView"] = 1;
  document["accessors"][1]["bufferView"] = 1;
  CHECK(triangles_of(mesh_of(glb(document, data))) == triangles_of(mesh_of(glb(tetrahedron()))));
}

TEST_CASE("draco: a stream is checked against the document") {
  const std::string file = draco_glb(draco_stream(kPositions, kTetrahedronCorners, 0, 5));
  CHECK(contains(refused_in(file, kDracoAt + "/attributes/POSITION", 7), "POSITION is attribute 7"));
  CHECK(contains(refused_in(file, kDracoAt + "/bufferView", 7), "bufferViews[7] does not exist"));
  CHECK(contains(refused_in(file, "/accessors/0/count", 5), "count is 5, but the Draco stream holds 4 points"));
  const json sparse = {
      {"count", 0}, {"indices", {{"bufferView", 0}, {"componentType", 5123}}}, {"values", {{"bufferView", 0}}}};
  CHECK(contains(refused_in(file, "/accessors/0/sparse", sparse), "is both sparse and compressed by Draco"));
  CHECK(contains(refused_in(file, "/buffers/0/byteLength", 9), "bufferViews[0] reaches beyond its buffer"));
  CHECK(contains(refused_in(file, "/meshes/0/primitives/0/mode", 6),
                 "meshes[0].primitives[0] of 'a': mode 6, a triangle fan, compressed by Draco"));
  CHECK(refused_in(file, "/meshes/0/primitives/0/mode", 5).empty());
  CHECK(contains(refused_in(file, kDracoAt, 1), "KHR_draco_mesh_compression of 'a': expected an object"));
}

TEST_CASE("draco: broken and cut streams are refused") {
  CHECK(contains(refusal(draco_glb("DRACO"), ""), "not a Draco stream"));
  CHECK(contains(refusal(draco_glb(std::string("DRACO\x02\x02\x00\x00\x00\x00", 11)), ""),
                 "of points, not of triangles"));
  CHECK(contains(refusal(draco_glb(std::string("DRACO\x02\x02\x01\x07\x00\x00", 11)), ""), "unknown encoding"));
  for (const int speed : {0, 10}) {
    const std::string whole = draco_stream(kPositions, kTetrahedronCorners, 11, speed);
    for (std::size_t length = 1; length < whole.size(); ++length) {
      CAPTURE(length);
      CHECK(!read(draco_glb(whole.substr(0, length)), "m.glb").ok());
      for (unsigned bit = 0; bit < 8; ++bit) {
        std::string changed = whole;
        changed[length] = static_cast<char>(static_cast<unsigned char>(changed[length]) ^ (1U << bit));
        const auto result = read(draco_glb(changed), "m.glb");
        if (!result) CHECK(contains(result.error().message, "'a'"));
      }
    }
  }
}

TEST_CASE("draco: a stream that claims 2^31 faces is refused before memory is allocated") {
  CHECK(code(draco_glb(claim(1'000'000'000, 0x80000000U / 2)), "") == ErrorCode::too_large);
  CHECK(contains(refusal(draco_glb(claim(3, 0x80000000U)), ""), "more triangles than the limit of 100000000"));
  CHECK(contains(refusal(draco_glb(claim(90'000'000, 90'000'000)), ""), "expands to more than 67108864 bytes"));
  CHECK(contains(refusal(draco_glb(claim(30'000, 30'000, '\xFF')), ""), "expands to more than 67108864 bytes"));
  CHECK(contains(refusal(draco_glb(claim(3'000'000'000, 1000)), ""), "more vertices than the limit"));
  ReadLimits limits;
  limits.max_triangles = 3;
  const auto result = read(draco_glb(draco_stream(kPositions, kTetrahedronCorners, 0, 5)), "", limits);
  REQUIRE(!result.ok());
  CHECK(contains(result.error().message, "more triangles than the limit of 3"));
}

TEST_CASE("meshopt: both extensions, with a missing fallback buffer") {
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const auto result = read(meshopt_glb(extension), "m.glb");
    REQUIRE(result.ok());
    CHECK(triangles_of(result->mesh) == triangles_of(mesh_of(glb(tetrahedron()))));
    CHECK(result->notes.remarks == std::vector<std::string>{"bufferViews decompressed by meshopt: 2"});
  }
}

TEST_CASE("meshopt: a view is checked against the document") {
  const std::string file = meshopt_glb("EXT_meshopt_compression");
  const auto refused = [&](const char* member, const json& value) {
    return refused_in(file, kMeshoptAt + "/" + member, value);
  };
  CHECK(contains(refused("mode", "STRIPS"), "bufferViews[0] of 'a': meshopt: the mode 'STRIPS' is unknown"));
  CHECK(contains(refused("filter", "COLOR"), "with the filter 'COLOR', which is for normals and colours"));
  CHECK(contains(refused("filter", "QUATERNION"), "the filter QUATERNION with a byteStride of 12; it needs 8"));
  CHECK(contains(refused("byteStride", 10), "a byteStride of 10, not a multiple of 4"));
  CHECK(contains(refused("byteStride", 0), "a byteStride of 0, not a multiple of 4"));
  CHECK(contains(refused("byteStride", 8), "count x byteStride is 32, but the bufferView has 48 bytes"));
  CHECK(contains(refused("count", 1 << 30), "1073741824 elements do not fit in"));
  CHECK(contains(refused("buffer", 9), "names buffer 9, which does not exist"));
  CHECK(contains(refused("byteOffset", 1000), "reaches beyond its buffer"));
  CHECK(contains(refused("byteLength", 20), "not a stream of 4 elements of 12 bytes in the mode ATTRIBUTES"));
  CHECK(contains(refused_in(file, "/bufferViews/1/extensions/EXT_meshopt_compression/filter", "COLOR"),
                 "the filter 'COLOR' in the mode TRIANGLES; only ATTRIBUTES may have one"));
  json both = document_of(file);
  both["bufferViews"][1]["extensions"]["KHR_meshopt_compression"] =
      both["bufferViews"][1]["extensions"]["EXT_meshopt_compression"];
  CHECK(contains(refusal(glb(both, data_of(file)), ""),
                 "bufferViews[1].extensions of 'a': has EXT_meshopt_compression and KHR_meshopt_compression"));
  CHECK(contains(refused("mode", "INDICES"), "a byteStride of 12, neither 2 nor 4"));
  CHECK(contains(refused_in(file, "/buffers/1/extensions", json::object()), "buffers[1] of 'a': has no data"));
}

TEST_CASE("meshopt: a view that claims a large size is refused before memory is allocated") {
  const std::string file = meshopt_glb("EXT_meshopt_compression");
  json document = document_of(file);
  std::string data = data_of(file);
  data.resize(2'000'000);
  document["buffers"][0]["byteLength"] = data.size();
  document["bufferViews"][0]["byteLength"] = std::size_t{256} * 100'000'000;
  document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(
      {{"byteLength", data.size()}, {"byteStride", 256}, {"count", 100'000'000}});
  CHECK(contains(refusal(glb(document, data), ""), "expands to more than 4"));
}

}  // namespace meshgauge::api::test
