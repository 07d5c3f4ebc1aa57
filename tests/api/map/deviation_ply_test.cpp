#include "api/map/deviation_ply.h"

#include <cmath>
#include <cstring>
#include <sstream>

#include <doctest/doctest.h>

#include "tests/api/map/deviation_maps.h"

using namespace meshgauge;
using api::test::MadeMap;

namespace {

std::string written(const api::DeviationMap& map) {
  std::ostringstream out;
  api::write_deviation_ply(map, out);
  return out.str();
}

bool says(const std::string& file, const std::string& line) {
  return file.find("\n" + line + "\n") != std::string::npos;
}

std::string body(const std::string& file) { return file.substr(file.find("end_header\n") + 11); }

template <class T>
T value_at(const std::string& bytes, std::size_t offset) {
  T value;
  REQUIRE(offset + sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

TEST_CASE("positions that are floats are written as floats, and the PLY reader reads the same mesh") {
  const MadeMap made(shapes::cube(0.5, {3, 0.25, 1}));
  const std::string file = written(made.map);
  CHECK(says(file, "property float x"));
  CHECK(api::test::read_back(file).positions == made.mesh.positions);
  CHECK(api::test::read_back(file).triangles == made.mesh.triangles);
}

TEST_CASE("if one position is not a float, all are doubles") {
  MadeMap made(shapes::cube());
  made.mesh.positions[5].y() = 0.1;
  const std::string file = written(made.map);
  CHECK(says(file, "property double x"));
  CHECK(api::test::read_back(file).positions == made.mesh.positions);
}

TEST_CASE("each vertex has its colour and its distance, as double and as float") {
  const MadeMap made(shapes::cube());
  const std::string file = written(made.map);
  const std::string bytes = body(file);
  constexpr std::size_t kVertex = 3 * 4 + 3 + 4 + 8;
  REQUIRE(bytes.size() == 8 * kVertex + 12 * 13);
  for (std::size_t v = 0; v < 8; ++v) {
    CHECK(value_at<api::Rgb>(bytes, v * kVertex + 12) == api::colour_of(made.distances[v], made.map.scale));
    CHECK(value_at<float>(bytes, v * kVertex + 15) == static_cast<float>(made.distances[v]));
    CHECK(value_at<double>(bytes, v * kVertex + 19) == made.distances[v]);
  }
  CHECK(value_at<api::Rgb>(bytes, 4 * kVertex + 12) == api::kAboveLimit);
}

TEST_CASE("the comments say what the numbers mean") {
  MadeMap made(shapes::cube());
  const std::string file = written(made.map);
  CHECK(says(file, "comment unit mm"));
  CHECK(says(file, "comment limit 0.125"));
  CHECK(says(file, "comment certified interval of the measurement 0.23 0.25"));
  CHECK(says(file, "comment witness from 0.5 2 3 triangle 7 of the baseline"));
  CHECK(says(file, "comment witness to 0.5 1 3 triangle 11 of the candidate"));
  CHECK(file.find("refined") == std::string::npos);
  made.map.scale.limited = false;
  made.map.candidate_vertices = 6;
  made.map.form = api::MapForm::refined;
  CHECK(says(written(made.map), "comment largest 0.125"));
  made.map.scale.limited = true;
  made.map.limit_side = "inside";
  CHECK(says(written(made.map), "comment limit 0.125 inside"));
  CHECK(says(written(made.map), "comment refined for display: the first 6 vertices are the candidate's"));
}

TEST_CASE("a unit cannot end its line") {
  MadeMap made(shapes::cube());
  made.map.units = "mm\nelement vertex 1000000000\r\n";
  const std::string file = written(made.map);
  CHECK(says(file, "comment unit mm element vertex 1000000000  "));
  CHECK(api::test::read_back(file).positions == made.mesh.positions);
}

TEST_CASE("deviation PLY: a cloud is written without faces, and read as one") {
  api::test::MadeMap made({{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, points_as_triangles(3)});
  made.map.candidate_triangles = 0;
  std::ostringstream out;
  api::write_deviation_ply(made.map, out);
  CHECK(out.str().find("element face") == std::string::npos);
  CHECK(api::test::read_back(out.str()).triangles == points_as_triangles(3));
}

TEST_CASE("a PLY with sides has a signed distance behind the distance, nan where the side is not proved") {
  MadeMap made(shapes::cube());
  CHECK(!says(written(made.map), "property double signed_distance"));
  const std::vector<std::int8_t> sides{0, 1, -1, 0, 1, 1, 1, -1};
  made.map.sides = sides;
  const std::string file = written(made.map), bytes = body(file);
  CHECK(says(file, "property double signed_distance"));
  CHECK(api::test::read_back(file).positions == made.mesh.positions);
  constexpr std::size_t kVertex = 3 * 4 + 3 + 4 + 8 + 8;
  REQUIRE(bytes.size() == 8 * kVertex + 12 * 13);
  const auto signed_of = [&](std::size_t v) { return value_at<double>(bytes, v * kVertex + 27); };
  CHECK(signed_of(0) == 0);  // a distance of 0 needs no side
  CHECK(signed_of(1) == made.distances[1]);
  CHECK(signed_of(2) == -made.distances[2]);
  CHECK(std::isnan(signed_of(3)));
}

TEST_CASE("a PLY with normals has them behind the position") {
  MadeMap made(shapes::cube());
  const std::vector<Vec3> normals(8, Vec3(0.6, 0, -0.8));
  made.map.normals = normals;
  const std::string file = written(made.map), bytes = body(file);
  CHECK(says(file, "property float nz\nproperty uchar red"));
  CHECK(api::test::read_back(file).positions == made.mesh.positions);
  constexpr std::size_t kVertex = 3 * 4 + 3 * 4 + 3 + 4 + 8;
  REQUIRE(bytes.size() == 8 * kVertex + 12 * 13);
  CHECK(value_at<float>(bytes, 7 * kVertex + 12) == 0.6F);
  CHECK(value_at<float>(bytes, 7 * kVertex + 20) == -0.8F);
  CHECK(value_at<double>(bytes, 7 * kVertex + 31) == made.distances[7]);
}

TEST_CASE("a PLY says why it has no signed distance, on one line") {
  MadeMap made(shapes::cube());
  CHECK(written(made.map).find("no signed_distance") == std::string::npos);
  made.map.no_sides = "the baseline is\nopen";
  CHECK(says(written(made.map), "comment no signed_distance: the baseline is open"));
}
