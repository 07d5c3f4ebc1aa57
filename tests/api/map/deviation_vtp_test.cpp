#include "api/map/deviation_vtp.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include <doctest/doctest.h>
#include <pugixml.hpp>

#include "tests/api/map/deviation_maps.h"

using namespace meshgauge;
using api::test::MadeMap;

namespace {

// The XML, and the arrays behind it.
struct Vtp {
  std::string file;
  pugi::xml_document document;
  std::string data;

  explicit Vtp(const api::DeviationMap& map) {
    std::ostringstream out;
    api::write_deviation_vtp(map, out);
    file = out.str();
    const std::string begin = "<AppendedData encoding=\"raw\">_", end = "</AppendedData>\n</VTKFile>\n";
    const auto at = file.find(begin) + begin.size();
    REQUIRE(file.ends_with(end));
    data = file.substr(at, file.size() - end.size() - at);
    const std::string text = file.substr(0, at) + end;
    REQUIRE(document.load_buffer(text.data(), text.size()));
  }

  pugi::xml_node piece() const { return document.child("VTKFile").child("PolyData").child("Piece"); }
  pugi::xml_node named(const char* name) const {
    return document.find_node([&](pugi::xml_node node) { return node.attribute("Name").value() == std::string(name); });
  }

  template <class T>
  std::vector<T> array(const char* name) const {
    const std::size_t at = named(name).attribute("offset").as_uint();
    std::uint64_t bytes = 0;
    REQUIRE(at + sizeof bytes <= data.size());
    std::memcpy(&bytes, data.data() + at, sizeof bytes);
    REQUIRE(at + sizeof bytes + bytes <= data.size());
    std::vector<T> values(bytes / sizeof(T));
    std::memcpy(values.data(), data.data() + at + sizeof bytes, bytes);
    return values;
  }
};

}  // namespace

TEST_CASE("a VTP has the mesh, the distances, and the facts") {
  MadeMap made(shapes::cube());
  const Vtp vtp(made.map);
  CHECK(vtp.piece().attribute("NumberOfPoints").as_int() == 8);
  CHECK(vtp.piece().attribute("NumberOfPolys").as_int() == 12);
  CHECK(vtp.array<double>("distance") == made.distances);
  const auto points = vtp.array<double>("Points");
  REQUIRE(points.size() == 24);
  for (std::size_t i = 0; i < 24; ++i) CHECK(points[i] == made.mesh.positions[i / 3][static_cast<int>(i % 3)]);
  const auto corners = vtp.array<std::int64_t>("connectivity");
  REQUIRE(corners.size() == 36);
  for (std::size_t i = 0; i < 36; ++i) CHECK(corners[i] == made.mesh.triangles[i / 3][i % 3]);
  CHECK(vtp.array<std::int64_t>("offsets").back() == 36);
  CHECK(vtp.named("limit").text().as_double() == 0.125);
  CHECK(vtp.named("lower").text().as_double() == 0.23);
  CHECK(vtp.named("upper").text().as_double() == 0.25);
  CHECK(!vtp.named("signed_distance"));
  CHECK(!vtp.named("limit_side"));
  made.map.limit_side = "inside";
  CHECK(Vtp(made.map).named("limit_side").text().as_double() == -1);
  made.map.upper = std::numeric_limits<double>::infinity();
  CHECK(!Vtp(made.map).named("upper"));
}

TEST_CASE("a VTP with normals says which array has them") {
  MadeMap made(shapes::cube());
  CHECK(!Vtp(made.map).named("Normals"));
  const std::vector<Vec3> normals(8, Vec3(0.6, 0, -0.8));
  made.map.normals = normals;
  const Vtp vtp(made.map);
  CHECK(vtp.piece().child("PointData").attribute("Normals").value() == std::string("Normals"));
  const auto found = vtp.array<double>("Normals");
  REQUIRE(found.size() == 24);
  CHECK(found[21] == 0.6);
  CHECK(found[23] == -0.8);
  CHECK(vtp.array<double>("Points")[23] == made.mesh.positions[7].z());
}

TEST_CASE("a VTP with sides has the signed distances, a cloud has vertices in place of faces") {
  MadeMap made(shapes::cube());
  const std::vector<std::int8_t> sides{0, 1, -1, 0, 1, 1, 1, -1};
  made.map.sides = sides;
  const auto found = Vtp(made.map).array<double>("signed_distance");
  CHECK(found[0] == 0);
  CHECK(found[1] == made.distances[1]);
  CHECK(found[2] == -made.distances[2]);
  CHECK(std::isnan(found[3]));
  CHECK(!Vtp(made.map).named("no_sides"));
  made.map.no_sides = "<\xc3\xa4";
  CHECK(Vtp(made.map).named("no_sides").text().as_string() == std::string("60 195 164 0"));
  made.map.candidate_triangles = 0;
  const Vtp cloud(made.map);
  CHECK(cloud.piece().attribute("NumberOfVerts").as_int() == 8);
  CHECK(cloud.piece().attribute("NumberOfPolys").as_int() == 0);
  CHECK(cloud.array<std::int64_t>("connectivity") == std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6, 7});
  CHECK(cloud.array<std::int64_t>("offsets").front() == 1);
}
