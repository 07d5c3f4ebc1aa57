#include "api/formats/file/readers.h"

#include <doctest/doctest.h>

#include <tuple>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {

namespace {

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

TEST_CASE("gltf: every mode of triangles, points and lines are counted") {
  json document = tetrahedron();
  json& primitives = document["meshes"][0]["primitives"];
  primitives[0] = {{"attributes", {{"POSITION", 0}}}, {"mode", 5}};
  CHECK(mesh_of(glb(document)).triangles == std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}});
  json joined = document;
  joined["meshes"][0]["primitives"][0]["indices"] = 1;
  joined["accessors"][1]["count"] = 9;  // 0 2 1 0 1 3 1 2 3, where 1 0 1 and 1 3 1 are joins
  const auto strip = read(glb(joined), "");
  REQUIRE(strip.ok());
  CHECK(strip->mesh.triangles == std::vector<Triangle>{{0, 2, 1}, {2, 0, 1}, {0, 3, 1}, {3, 2, 1}, {1, 2, 3}});
  CHECK(strip->notes.skipped_primitives == 2);
  primitives[0]["mode"] = 6;
  CHECK(mesh_of(glb(document)).triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
  primitives.push_back(primitives[0]);
  primitives[1]["indices"] = 1;
  const Mesh shared = mesh_of(glb(document));
  CHECK(shared.positions.size() == 4);
  CHECK(shared.triangles.size() == 2 + 10);
  for (const int mode : {0, 1, 2, 3}) primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  CHECK(read(glb(document), "")->notes.skipped_primitives == 4);
  primitives = json::array({primitives[3]});
  CHECK(code(glb(document), "") == ErrorCode::empty_mesh);
  primitives[0]["mode"] = 7;
  CHECK(contains(refusal(glb(document), ""), "mode 7 does not exist"));
  primitives[0]["mode"] = 4;
  CHECK(code(glb(document), "") == std::nullopt);
}

TEST_CASE("gltf: an incomplete last triangle is left out, and noted") {
  const std::string note = "corners of incomplete last triangles, left out: ";
  json document = tetrahedron();
  json& primitives = document["meshes"][0]["primitives"];
  for (const int count : {10, 11}) {
    document["accessors"][1]["count"] = count;
    const auto result = read(glb(document), "");
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles == std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}});
    CHECK(result->notes.remarks == std::vector{note + std::to_string(count - 9)});
  }
  primitives[0].erase("indices");  // four vertices
  CHECK(read(glb(document), "")->notes.remarks == std::vector{note + "1"});
  document["accessors"][1]["count"] = 2;
  primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 5}});
  CHECK(read(glb(document), "")->notes.remarks == std::vector{note + "3"});
  primitives = json::array({primitives[1]});
  CHECK(code(glb(document), "") == ErrorCode::empty_mesh);
}

TEST_CASE("gltf: an index that restarts a primitive is refused") {
  const auto with_last = [](int type, const std::string& index) {
    json document = tetrahedron();
    std::string data = tetrahedron_data().substr(0, 48);
    for (int i = 0; i < 5; ++i) data += std::string(1, static_cast<char>(i % 3)) + std::string(index.size() - 1, '\0');
    data += index;
    document["buffers"][0]["byteLength"] = data.size();
    document["bufferViews"][1]["byteLength"] = data.size() - 48;
    document["accessors"][1].update({{"componentType", type}, {"count", 6}});
    document["meshes"][0]["primitives"][0]["mode"] = 5;
    return refusal(glb(document, data), "");
  };
  for (const auto& [type, bytes, name] :
       {std::tuple(5121, 1, "255"), std::tuple(5123, 2, "65535"), std::tuple(5125, 4, "4294967295")}) {
    CHECK(contains(with_last(type, std::string(static_cast<std::size_t>(bytes), '\xFF')),
                   std::string("primitives[0] of 'a': index ") + name +
                       " at place 5, the largest of its type, which restarts a primitive in some programs"));
  }
  // Refused even where there is such a vertex.
  json document = tetrahedron();
  const std::string data(std::size_t{256} * 12, '\0');
  document["buffers"][0]["byteLength"] = data.size() + 3;
  document["bufferViews"][0]["byteLength"] = data.size();
  document["bufferViews"][1] = {{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", 3}};
  document["accessors"][0]["count"] = 256;
  document["accessors"][1].update({{"componentType", 5121}, {"count", 3}});
  CHECK(refusal(glb(document, data + "\x01\x02\xFE"), "").empty());
  CHECK(contains(refusal(glb(document, data + "\x01\x02\xFF"), ""), "index 255 at place 2, the largest"));
}

TEST_CASE("gltf: meshes outside the scene are counted") {
  json document = tetrahedron();
  CHECK(read(glb(document), "")->notes.unused_objects == 0);
  document["meshes"].push_back(document["meshes"][0]);
  document["nodes"].push_back({{"mesh", 1}});
  CHECK(read(glb(document), "")->notes.unused_objects == 1);
  document["scenes"][0]["nodes"] = {0, 1};
  CHECK(read(glb(document), "")->notes.unused_objects == 0);
  document["nodes"].push_back({{"mesh", 1}});
  document["nodes"].push_back({{"mesh", 1}});
  CHECK(read(glb(document), "")->notes.unused_objects == 0);
  CHECK(read(glb(document), "")->notes.remarks ==
        std::vector<std::string>{"nodes outside the scene whose mesh is also in it, left out: 2"});
}

TEST_CASE("gltf: hidden nodes and all below them are left out") {
  json document = tetrahedron();
  const json hidden = {{"KHR_node_visibility", {{"visible", false}}}};
  const json visible = {{"KHR_node_visibility", {{"visible", true}}}};
  document["nodes"] = {{{"mesh", 0}, {"extensions", visible}},
                       {{"children", {2}}, {"extensions", hidden}},
                       {{"mesh", 1}, {"extensions", visible}}};
  document["meshes"].push_back(document["meshes"][0]);
  document["scenes"][0]["nodes"] = {0, 1};
  for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
    document[key] = {"KHR_node_visibility"};
    const auto result = read(glb(document), "");
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles.size() == 4);
    CHECK(result->notes.unused_objects == 0);
    CHECK(result->notes.remarks ==
          std::vector<std::string>{"nodes with a mesh that KHR_node_visibility hides, left out: 1"});
  }
  document["nodes"][0]["extensions"] = hidden;
  CHECK(code(glb(document), "") == ErrorCode::empty_mesh);
  CHECK(contains(refusal(glb(document), ""), "KHR_node_visibility hides 2 nodes with meshes"));
  document["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = 0;
  CHECK(contains(refusal(glb(document), ""), "KHR_node_visibility.visible of 'a': expected true or false"));
}

// Takes minutes if memory grows by one instance at a time.
TEST_CASE("gltf: a hundred thousand instances") {
  json document = tetrahedron();
  for (int i = 1; i < 100'000; ++i) {
    document["nodes"].push_back({{"mesh", 0}});
    document["scenes"][0]["nodes"].push_back(i);
  }
  CHECK(mesh_of(glb(document)).triangles.size() == 400'000);
}

TEST_CASE("gltf: references to missing items are refused") {
  CHECK(contains(refused("/scenes/0/nodes", {7}), "the scene of 'a': nodes[7] does not exist"));
  CHECK(contains(refused("/nodes/0/children", {7}), "nodes[0] of 'a': nodes[7] does not exist"));
  CHECK(contains(refused("/nodes/0/mesh", 3), "meshes[3] of 'a': does not exist"));
  CHECK(contains(refused("/meshes/0/primitives/0/attributes/POSITION", 5), "accessors[5] of 'a': does not exist"));
  CHECK(contains(refused("/meshes/0/primitives/0/indices", 5), "accessors[5] of 'a': does not exist"));
  CHECK(contains(refused("/accessors/0/bufferView", 5), "accessors[0] of 'a': bufferViews[5] does not exist"));
  CHECK(contains(refused("/bufferViews/0/buffer", 5), "names buffer 5, which does not exist"));
  CHECK(contains(refused_without("/meshes/0/primitives/0/attributes", "POSITION"), "no attribute POSITION"));
}

TEST_CASE("gltf: cycles, ladders and long chains of nodes end") {
  json document = tetrahedron();
  document["nodes"] = {{{"children", {1}}}, {{"children", {0}}, {"mesh", 0}}};
  CHECK(contains(refusal(glb(document), ""), "scenes[0] of 'a': names nodes[0], which is a child of another node"));
  document["nodes"] = {{{"children", {1}}}, {{"children", {2}}, {"mesh", 0}}, {{"children", {1}}}};
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
