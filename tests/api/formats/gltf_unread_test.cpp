// Extensions that bring or change surface, and what else a glTF says of it, are noted or refused by name.
#include "api/formats/gltf/gltf_extensions.h"

#include <doctest/doctest.h>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {
namespace {

const std::string kUnread = "not read and not measured, though part of the surface: ";

std::vector<std::string> remarks(const json& document) {
  const auto result = read(glb(document), "m.glb");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  CHECK(result->mesh.triangles.size() == 4);
  return result->notes.remarks;
}

// The remarks on a tetrahedron with an extension on the object at `pointer`.
std::vector<std::string> with(const std::string& pointer, const std::string& extension) {
  json document = tetrahedron();
  document["materials"] = {json::object()};
  document[json::json_pointer(pointer)]["extensions"][extension] = json::object();
  return remarks(document);
}

const std::string kPrimitive = "/meshes/0/primitives/0";

}  // namespace

TEST_CASE("gltf: unknown extensions of primitives, meshes and nodes are noted by name") {
  CHECK(with(kPrimitive, "ABC_other") == std::vector{kUnread + "extensions ABC_other on primitives: 1"});
  CHECK(with("/meshes/0", "ABC_other") == std::vector{kUnread + "extensions ABC_other on meshes: 1"});
  CHECK(with("/nodes/0", "ABC_other") == std::vector{kUnread + "extensions ABC_other on nodes: 1"});
  CHECK(with("/materials/0", "ABC_other").empty());
  CHECK(with("/accessors/0", "ABC_other").empty());
  CHECK(with("", "ABC_other").empty());
  json document = tetrahedron();
  document["extensionsUsed"] = {"ABC_other"};
  document["nodes"].push_back(document["nodes"][0]);
  document["scenes"][0]["nodes"] = {0};
  for (json& node : document["nodes"]) node["extensions"]["ABC_other"] = nullptr;
  CHECK(read(glb(document), "")->notes.remarks.front() == kUnread + "extensions ABC_other on nodes: 2");
  document["extensionsRequired"] = {"ABC_other"};
  CHECK(code(glb(document), "") == ErrorCode::unsupported_format);
}

TEST_CASE("gltf: extensions that are read are unknown where they do not belong") {
  CHECK(with("/meshes/0", "KHR_draco_mesh_compression") ==
        std::vector{kUnread + "extensions KHR_draco_mesh_compression on meshes: 1"});
  CHECK(with(kPrimitive, "EXT_mesh_gpu_instancing") ==
        std::vector{kUnread + "extensions EXT_mesh_gpu_instancing on primitives: 1"});
  CHECK(with("/nodes/0", "KHR_node_visibility").empty());
}

TEST_CASE("gltf: extensions without effect on the surface are not noted") {
  for (const char* name : {"KHR_materials_variants", "EXT_mesh_features", "FB_ngon_encoding", "KHR_xmp_json_ld",
                           "EXT_mesh_manifold", "EXT_mesh_primitive_restart", "CESIUM_primitive_outline"}) {
    CHECK(with(kPrimitive, name).empty());
    CHECK(with("/meshes/0", name).empty());
  }
  for (const char* name :
       {"KHR_lights_punctual", "KHR_physics_rigid_bodies", "OMI_physics_body", "KHR_audio_emitter"}) {
    CHECK(with("/nodes/0", name).empty());
  }
  CHECK(refused("/extensionsRequired", json::array({"EXT_mesh_manifold"})) != "");
}

TEST_CASE("gltf: extensions that are surface are noted by their kind") {
  CHECK(with("/materials/0", "KHR_materials_displacement") ==
        std::vector{kUnread + "materials that displace the surface (KHR_materials_displacement): 1"});
  CHECK(contains(refused("/extensionsRequired", json::array({"KHR_materials_displacement"})),
                 "'KHR_materials_displacement' is not supported"));
  CHECK(with(kPrimitive, "KHR_gaussian_splatting") ==
        std::vector{kUnread + "primitives of Gaussian splats (KHR_gaussian_splatting): 1"});
  CHECK(with(kPrimitive, "MPEG_primitive_V3C") ==
        std::vector{kUnread + "primitives of coded volumetric video (MPEG_primitive_V3C): 1"});
  CHECK(with("/meshes/0", "NEEDLE_progressive") ==
        std::vector{kUnread + "finer levels of detail outside the file (NEEDLE_progressive): 1"});
  CHECK(with("/nodes/0", "EXT_text") == std::vector{kUnread + "texts (EXT_text): 1"});
}

TEST_CASE("gltf: voxels and implicit regions beside triangles are noted, alone they are refused") {
  const std::string voxels = "primitives of voxels (EXT_primitive_voxels): 1";
  const std::string ellipsoids = "implicit ellipsoids (EXT_implicit_ellipsoid_region): 1";
  json document = tetrahedron();
  json& primitives = document["meshes"][0]["primitives"];
  primitives.push_back({{"attributes", {{"_DENSITY", 1}}},
                        {"mode", 2147483647},
                        {"extensions", {{"EXT_primitive_voxels", {{"shape", 0}}}}}});
  CHECK(remarks(document) == std::vector{kUnread + voxels});
  primitives.push_back(
      {{"attributes", {{"_DENSITY", 1}}}, {"extensions", {{"EXT_implicit_ellipsoid_region", json::object()}}}});
  CHECK(remarks(document) == std::vector{kUnread + voxels, kUnread + ellipsoids});
  primitives.erase(0);
  CHECK(refusal(glb(document), "") ==
        "'a' has no triangles, only what is not read (" + voxels + ", " + ellipsoids + "): export it as triangles");
  CHECK(code(glb(document), "") == ErrorCode::unsupported_format);
  primitives[0].erase("extensions");
  CHECK(contains(refusal(glb(document), ""), "mode 2147483647 does not exist"));
}

TEST_CASE("gltf: a node of an unknown extension alone is refused by its name") {
  json document = tetrahedron();
  document["nodes"][0] = {{"extensions", {{"ABC_shape", {{"radius", 1}}}}}};
  CHECK(refusal(glb(document), "") ==
        "'a' has no triangles, only what is not read (extensions ABC_shape on nodes: 1): export it as triangles");
}

TEST_CASE("gltf: points with an extension are a cloud, and the extension is noted") {
  json document = tetrahedron();
  document["meshes"][0]["primitives"][0]["mode"] = 0;
  document["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"] = json::object();
  const auto result = read(glb(document), "");
  REQUIRE(result.ok());
  CHECK(result->notes.cloud);
  CHECK(result->notes.remarks == std::vector{kUnread + "primitives of Gaussian splats (KHR_gaussian_splatting): 1"});
}

TEST_CASE("gltf: animations, levels of detail, variants and articulations are noted") {
  json document = tetrahedron();
  document["animations"] = {json::object(), json::object()};
  document["nodes"].push_back({{"extensions", {{"MSFT_lod", json::object()}, {"AGI_articulations", json::object()}}}});
  document["nodes"][0]["extensions"] = {{"MSFT_lod", json::object()}, {"MAXAR_mesh_variants", json::object()}};
  CHECK(remarks(document) ==
        std::vector<std::string>{
            "animations not applied: 2", "nodes that articulations move, which are not applied (AGI_articulations): 1",
            "nodes with further levels of detail, of which the first is read (MSFT_lod): 2",
            "nodes with variants of their mesh, of which the default is read (MAXAR_mesh_variants): 1"});
  document = tetrahedron();
  document["animations"] = 7;
  CHECK(remarks(document).empty());
}

TEST_CASE("gltf: any number of unknown extensions fits the remarks of a mesh") {
  json document = tetrahedron();
  for (int i = 0; i < 1000; ++i) {
    document["nodes"][0]["extensions"][std::to_string(i) + std::string(500, '\x01')] = json::object();
  }
  document["animations"] = {json::object()};
  const auto all = remarks(document);
  CHECK(all.size() == Unread::kMostKinds + 1);
  CHECK(contains(all[Unread::kMostKinds - 1], "all other kinds: 993"));
  CHECK(all.back() == "animations not applied: 1");
  for (const std::string& remark : all) CHECK(remark.size() <= kMaxRemarkBytes);
}

}  // namespace meshgauge::api::test
