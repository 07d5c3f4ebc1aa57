// Small files that ask for hours of work: each is refused with the place, or its mesh is made without it.
#include <doctest/doctest.h>

#include "tests/api/formats/gltf_compressed.h"
#include "tests/api/formats/gltf_files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

void check_refused(const std::string& content, const std::string& where, const std::string& what) {
  const auto result = read(content, "");
  REQUIRE(!result.ok());
  CHECK(result.error().code == ErrorCode::too_large);
  CAPTURE(result.error().message);
  CHECK(contains(result.error().message, where + "'a'"));
  CHECK(contains(result.error().message, what));
}

// The mesh of the tetrahedron a million times: by instances without bytes, all at the origin.
json a_million_times() {
  json document = tetrahedron();
  document["accessors"].push_back({{"componentType", 5126}, {"count", 1'000'000}, {"type", "VEC3"}});
  document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 2;
  return document;
}

// Indices without bytes, all 0: a strip of joins only.
json of_joins(json document, std::size_t count) {
  document["accessors"][1] = {{"componentType", 5125}, {"count", count}, {"type", "SCALAR"}};
  document["meshes"][0]["primitives"][0]["mode"] = 5;
  return document;
}

const std::string kTooLong = "takes too long: nodes, instances, primitives and morph targets";

}  // namespace

TEST_CASE("bombs: primitives without triangles, times instances") {
  json document = a_million_times();
  json& primitives = document["meshes"][0]["primitives"];
  for (const int mode : {0, 5}) {
    primitives = json(1000, {{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
    if (mode == 5) document["accessors"][0]["count"] = 2;
    check_refused(glb(document), "of ", kTooLong);
  }
}

TEST_CASE("bombs: joins of strips, times instances and times nodes") {
  check_refused(glb(of_joins(a_million_times(), 1'000'000)), "meshes[0].primitives[0] of ", kTooLong);
  json document = of_joins(tetrahedron(), 1'000'000);
  for (int i = 1; i < 10'000; ++i) {
    document["nodes"].push_back({{"mesh", 0}});
    document["scenes"][0]["nodes"].push_back(i);
  }
  check_refused(glb(document), "of ", kTooLong);
}

TEST_CASE("bombs: morph targets of one accessor, with and without a weight") {
  for (const double weight : {0.0, 1.0}) {
    json document = weight == 0 ? a_million_times() : tetrahedron();
    if (weight != 0) document["accessors"][0] = {{"componentType", 5126}, {"count", 1'000'000}, {"type", "VEC3"}};
    document["meshes"][0]["primitives"][0]["targets"] = json(1000, {{"POSITION", 0}});
    document["meshes"][0]["weights"] = json(1000, weight);
    check_refused(glb(document), "of ", kTooLong);
  }
}

TEST_CASE("bombs: one stream of Draco, decoded for many primitives") {
  std::vector<float> positions;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    for (const std::uint32_t c : {i, i * i, 1U}) positions.push_back(static_cast<float>(c));
    if (i >= 2) corners.insert(corners.end(), {i - 2, i - 1, i});
  }
  const std::string stream = draco_stream(positions, corners, 0, 5);
  const std::string file = draco_glb(stream);
  std::uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, sizeof length);
  json document = json::parse(file.substr(20, length));
  json& primitives = document["meshes"][0]["primitives"];
  primitives = json(3000, primitives[0]);
  for (json& accessor : document["accessors"]) accessor["count"] = corners.size();
  check_refused(glb(document, stream), "", "bytes of compressed glTF");
}

TEST_CASE("bombs: a buffer that is named often, and expanded by its archive, does not raise the limit") {
  json document = tetrahedron();
  document["buffers"] = json(100, {{"byteLength", 20'000'000}, {"uri", "x.bin"}});
  document["bufferViews"][0]["byteLength"] = 100'000'000;
  document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0}, {"byteLength", 20'000'000}, {"byteStride", 4}, {"count", 25'000'000}, {"mode", "ATTRIBUTES"}};
  document["accessors"][0]["count"] = 25'000'000;
  check_refused(zip({{"m.gltf", document.dump()}, {"x.bin", std::string(20'000'000, '\0')}}), "",
                "expands to more than 67108864 bytes");
}

TEST_CASE("bombs: an object of a 3MF whose triangles are left out, placed often") {
  constexpr int kTriangles = 300'000, kPlaced = 900'000;
  const std::string triangle = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";
  std::string object = triangle_object(1), more, components;
  for (int i = 0; i < kTriangles; ++i) more += triangle;
  for (int i = 0; i < kPlaced; ++i) components += "<component objectid=\"1\"/>";
  object.insert(object.find(triangle), more);
  object += "<object id=\"2\"><components>" + components + "</components></object>";
  for (const int left : {1, 0}) {
    const std::string config = "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"" +
                               std::to_string(kTriangles - left) +
                               "\"><metadata key=\"modifier\" value=\"1\"/></volume></object></config>";
    const auto result =
        read(package(model(object, "<item objectid=\"2\"/>"), {{"Metadata/Slic3r_PE_model.config", config}}), "");
    CHECK(result.ok() == (left == 1));
    if (result) CHECK(result->mesh.triangles.size() == kPlaced);
    if (!result) CHECK(contains(result.error().message, "has no printed triangles"));
  }
}

}  // namespace meshgauge::api::test
