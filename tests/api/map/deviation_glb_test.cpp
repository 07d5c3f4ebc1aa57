#include "api/map/deviation_glb.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/map/deviation_maps.h"

using namespace meshgauge;
using api::test::MadeMap;
using nlohmann::json;

namespace {

// The two chunks of a GLB.
struct Glb {
  std::string file;
  json document;
  std::string data;

  explicit Glb(const api::DeviationMap& map) {
    std::ostringstream out;
    const auto done = api::write_deviation_glb(map, out);
    INFO((done ? "" : done.error().message));
    REQUIRE(done.ok());
    file = out.str();
    const auto json_bytes = number<std::uint32_t>(file, 12);
    document = json::parse(file.substr(20, json_bytes));
    data = file.substr(28 + json_bytes, number<std::uint32_t>(file, 20 + json_bytes));
    CHECK(number<std::uint32_t>(file, 8) == file.size());
  }

  template <class T>
  static T number(const std::string& bytes, std::size_t offset) {
    T value;
    REQUIRE(offset + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
  }

  const json& primitive(std::size_t mesh) const { return document["meshes"][mesh]["primitives"][0]; }
  const json& accessor(std::size_t mesh, const char* attribute) const {
    return document["accessors"][primitive(mesh)["attributes"][attribute].get<std::size_t>()];
  }
  template <class T>
  T element(const json& accessor, std::size_t i) const {
    const json& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    return number<T>(data, view.value("byteOffset", std::size_t{0}) + i * sizeof(T));
  }
};

using Float3 = std::array<float, 3>;
using Colour = std::array<std::uint16_t, 4>;

}  // namespace

TEST_CASE("the candidate's primitive has the mesh's counts, bounds and numbers") {
  const MadeMap made(shapes::cube(0.5, {0.25, -0.25, 0}));
  const Glb glb(made.map);
  const json& positions = glb.accessor(0, "POSITION");
  CHECK(positions["count"] == 8);
  CHECK(positions["min"] == json({0.25, -0.25, 0}));
  CHECK(positions["max"] == json({0.75, 0.25, 0.5}));
  CHECK(glb.document["accessors"][glb.primitive(0)["indices"].get<std::size_t>()]["count"] == 36);
  const json& colours = glb.accessor(0, "COLOR_0");
  CHECK(colours["normalized"] == true);
  for (std::size_t v = 0; v < 8; ++v) {
    const Vec3& p = made.mesh.positions[v];
    CHECK(glb.element<Float3>(positions, v) == Float3{float(p.x()), float(p.y()), float(p.z())});
    CHECK(glb.element<float>(glb.accessor(0, "_DISTANCE"), v) == static_cast<float>(made.distances[v]));
    const auto linear = api::to_linear(api::colour_of(made.distances[v], made.map.scale));
    const auto colour = glb.element<Colour>(colours, v);
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(colour[i] / 65535.0 - linear[i]) < 1e-5);
    CHECK(colour[3] == 0xffff);
  }
  CHECK_FALSE(glb.document["nodes"][0].contains("translation"));
}

TEST_CASE("our own reader finds the candidate and not the witness") {
  const MadeMap made(shapes::cube(0.5));
  const Mesh read = api::test::read_back(Glb(made.map).file);
  CHECK(read.positions == made.mesh.positions);
  CHECK(read.triangles == made.mesh.triangles);
}

TEST_CASE("far from 0 the nodes have a translation, and positions have the precision of the mesh's size") {
  const Vec3 far_away(1e7 + 0.1, -2e9, 0);
  const MadeMap made(shapes::moved(shapes::sphere(8, 0.01), far_away));
  const Glb glb(made.map);
  const json& moved = glb.document["nodes"][0]["translation"];
  CHECK(moved[0] == 1e7);
  CHECK(moved[1] == -2e9);
  CHECK(moved[2] == 0);
  CHECK(glb.document["nodes"][1]["translation"] == moved);
  for (std::size_t k = 0; k < 3; ++k) CHECK(moved[k].get<double>() == double(moved[k].get<float>()));
  const Mesh read = api::test::read_back(glb.file);
  REQUIRE(read.positions.size() == made.mesh.positions.size());
  for (std::size_t v = 0; v < read.positions.size(); ++v) {
    const Vec3 wrong = read.positions[v] - made.mesh.positions[v];
    CHECK(std::abs(wrong.x()) <= 0.02 * 0x1p-24 + 1e7 * 0x1p-48);
    CHECK(std::abs(wrong.y()) <= 0x1p-22);  // an ulp of the double itself
    CHECK(std::abs(wrong.z()) <= 0.02 * 0x1p-24);
  }
}

TEST_CASE("the witness is a node of lines between the two meshes") {
  const MadeMap made(shapes::cube());
  const Glb glb(made.map);
  CHECK(glb.document["nodes"][1]["name"] == "witness");
  CHECK(glb.primitive(1)["mode"] == 1);
  CHECK_FALSE(glb.primitive(1).contains("indices"));
  const json& ends = glb.accessor(1, "POSITION");
  CHECK(ends["count"] == 8);
  CHECK(glb.element<Float3>(ends, 0) == Float3{0.5F, 2, 3});
  CHECK(glb.element<Float3>(ends, 1) == Float3{0.5F, 1, 3});
  CHECK(glb.document["extensionsUsed"] == json({"KHR_materials_unlit"}));
  CHECK(glb.document["materials"][1]["extensions"].contains("KHR_materials_unlit"));

  MadeMap without(shapes::cube());
  without.map.witness.reset();
  CHECK(Glb(without.map).document["nodes"].size() == 1);
}

TEST_CASE("at the edge of what a float holds the cross has shorter arms") {
  constexpr double kMost = std::numeric_limits<float>::max();
  MadeMap made(shapes::cube(2 * kMost, {-kMost, -kMost, -kMost}));
  made.map.witness->from = Vec3::Constant(kMost);
  made.map.witness->to = Vec3::Constant(-kMost);
  const Glb glb(made.map);
  const json& ends = glb.accessor(1, "POSITION");
  CHECK(ends["min"] == json({-kMost, -kMost, -kMost}));
  CHECK(ends["max"] == json({kMost, kMost, kMost}));
  for (std::size_t i = 0; i < 8; ++i) {
    for (const float x : glb.element<Float3>(ends, i)) CHECK(std::isfinite(x));
  }
}

TEST_CASE("the extras say what the numbers mean") {
  MadeMap made(shapes::cube());
  const json extras = Glb(made.map).document["nodes"][0]["extras"];
  CHECK(extras["limit"] == 0.125);
  CHECK(!extras.contains("limit_side"));
  made.map.limit_side = "outside";
  CHECK(Glb(made.map).document["nodes"][0]["extras"]["limit_side"] == "outside");
  CHECK(extras["units"] == "mm");
  CHECK(extras["lower"] == 0.23);
  CHECK(extras["upper"] == 0.25);
  CHECK(extras["candidate_vertices"] == 8);
  CHECK(extras["candidate_triangles"] == 12);
  CHECK(extras["witness"]["from_candidate"] == false);
  CHECK(extras["witness"]["from"] == json({0.5, 2.0, 3.0}));
  CHECK(extras["witness"]["to_triangle"] == 11);
}

TEST_CASE("numbers beyond single precision are refused by name") {
  MadeMap made(shapes::cube());
  made.distances[3] = 1e39;
  std::ostringstream out;
  auto refused = api::write_deviation_glb(made.map, out);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(refused.error().message.find("vertex 3 is beyond single precision") != std::string::npos);
  CHECK(out.str().empty());
  made.distances[3] = 0;
  made.mesh.positions[2].x() = -4e38;
  CHECK(api::write_deviation_glb(made.map, out).error().message.find("vertex 2") != std::string::npos);
  made.mesh.positions[2].x() = 0;
  made.map.witness->to.z() = 1e300;
  CHECK(api::write_deviation_glb(made.map, out).error().message.find("the witness") != std::string::npos);
}

TEST_CASE("deviation GLB: a cloud is written as points, and without its line read as one") {
  MadeMap made({{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, points_as_triangles(3)});
  made.map.candidate_triangles = 0;
  const Glb glb(made.map);
  CHECK(glb.primitive(0)["mode"] == 0);
  CHECK(!glb.primitive(0).contains("indices"));
  CHECK(api::test::read_back(glb.file).positions.empty());  // the line of the witness is no point
  made.map.witness.reset();
  CHECK(api::test::read_back(Glb(made.map).file).positions == made.mesh.positions);
}

TEST_CASE("a GLB with sides has them beside the distances, and only then") {
  MadeMap made(shapes::cube());
  CHECK(!Glb(made.map).primitive(0)["attributes"].contains("_SIDE"));
  const std::vector<std::int8_t> sides{0, 1, -1, 1, 1, 0, -1, -1};
  made.map.sides = sides;
  const Glb glb(made.map);
  const json& side = glb.accessor(0, "_SIDE");
  CHECK(side["count"] == 8);
  for (std::size_t v = 0; v < 8; ++v) CHECK(glb.element<float>(side, v) == static_cast<float>(sides[v]));
  CHECK(!glb.document["nodes"][0]["extras"].contains("no_sides"));
  made.map.no_sides = "the baseline is open";
  CHECK(Glb(made.map).document["nodes"][0]["extras"]["no_sides"] == "the baseline is open");
}

TEST_CASE("a GLB has normals where they are asked for") {
  MadeMap made(shapes::cube());
  CHECK(!Glb(made.map).primitive(0)["attributes"].contains("NORMAL"));
  const std::vector<Vec3> normals(8, Vec3(0, 0, -1));
  made.map.normals = normals;
  const Glb glb(made.map);
  const json& normal = glb.accessor(0, "NORMAL");
  CHECK(normal["type"] == "VEC3");
  CHECK(normal["count"] == 8);
  CHECK(glb.element<std::array<float, 3>>(normal, 7) == std::array<float, 3>{0, 0, -1});
  CHECK(api::test::read_back(glb.file).positions.size() >= 8);
}

TEST_CASE("a GLB has the side of the position that it rounds, where that is sure") {
  MadeMap made(shapes::cube());
  const double rounded = 0.3 * (1 - 1e-9);  // single precision moves it by more than 1e-9
  made.mesh.positions[1].x() = made.mesh.positions[2].x() = rounded;
  made.distances[1] = 1e-9;
  made.distances[2] = 1e-6;
  const std::vector<std::int8_t> sides(8, -1);
  made.map.sides = sides;
  const Glb glb(made.map);
  const json& side = glb.accessor(0, "_SIDE");
  CHECK(glb.element<float>(side, 1) == 0);
  CHECK(glb.element<float>(side, 2) == -1);
}
