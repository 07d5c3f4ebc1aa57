#include "api/formats/stl.h"

#include <doctest/doctest.h>

#include <limits>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

std::string facet(const std::array<float, 9>& corners, float normal = 0) {
  std::string out = raw(normal) + raw(normal) + raw(normal);
  for (const float c : corners) out += raw(c);
  return out + std::string(2, '\xAB');  // attribute bytes, as colours use them
}

std::string binary(const std::string& facets, std::uint32_t count, std::string header = "made by a test") {
  header.resize(80, '\0');
  return header + raw(count) + facets;
}

const std::array<float, 9> kCorners = {0, 0, 0, 1, 0, 0, 0, 1.1F, -0.0F};
const std::string kFacet = facet(kCorners);
const std::string kAscii =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1.5 -2e-1\n endloop\nendfacet\n";

}  // namespace

TEST_CASE("stl: a binary file gives three vertices a facet, exactly") {
  auto result = read(binary(kFacet + kFacet, 2), "m.stl");
  REQUIRE(result.ok());
  CHECK(result->format == Format::stl);
  CHECK(result->mesh.positions.size() == 6);
  CHECK(result->mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}});
  CHECK(result->mesh.positions[2] == Vec3(0, static_cast<double>(1.1F), 0));
}

TEST_CASE("stl: binary is told by its size, whatever the header and the name say") {
  for (const char* header : {"solid", "solid part one", "solid x\nfacet normal 0 0 1\n", "", "v 1 2 3"}) {
    for (const char* name : {"m.stl", "m.obj", ""}) {
      auto result = read(binary(kFacet, 1, header), name);
      REQUIRE(result.ok());
      CHECK(result->format == Format::stl);
      CHECK(result->mesh.triangles.size() == 1);
    }
  }
}

TEST_CASE("stl: normals are not looked at") {
  CHECK(read(binary(facet(kCorners, std::numeric_limits<float>::quiet_NaN()), 1), "m.stl").ok());
  std::string text = "solid\n" + kAscii + "endsolid\n";
  text.replace(text.find("0 0 1"), 5, "nan nan nan");
  CHECK(read(text, "m.stl").ok());
}

TEST_CASE("stl: a binary file of any other size is refused") {
  CHECK(contains(refusal(binary(kFacet, 2), "m.stl"), "truncated: the count of 2 facets asks for 184 bytes"));
  CHECK(contains(refusal(binary(kFacet + kFacet, 1), "m.stl"), "left-over bytes: the count of 1 facets"));
  CHECK(contains(refusal(binary(kFacet, 1) + "x", "m.stl"), "byte 134 of 'a': left-over"));
  CHECK(contains(refusal(binary(kFacet, 0xFFFFFFFF), "m.stl"), "truncated"));
  CHECK(contains(refusal(binary(kFacet, 2, "solid"), "m.stl"), "truncated"));
  CHECK(contains(refusal("STL", "m.stl"), "truncated"));
  CHECK(code(binary("", 0), "m.stl") == ErrorCode::empty_mesh);
}

TEST_CASE("stl: coordinates that are not finite are refused with their byte") {
  for (std::size_t k = 0; k < 9; ++k) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
      auto corners = kCorners;
      corners[k] = bad;
      const std::string file = binary(kFacet + facet(corners), 2);
      CHECK(code(file, "m.stl") == ErrorCode::non_finite_vertex);
      CHECK(contains(refusal(file, "m.stl"), "byte " + std::to_string(84 + 50 + 12 + 4 * k) + " of 'a'"));
    }
  }
  auto corners = kCorners;
  corners[3] = std::numeric_limits<float>::max();
  CHECK(read(binary(facet(corners), 1), "m.stl").ok());
}

TEST_CASE("stl: ascii, of one solid or more, in any case of letters") {
  std::string capitals = "solid two\n" + kAscii + "endsolid two\n";
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  auto result = read("solid one two\n" + kAscii + kAscii + "endsolid one two\r\n\n" + capitals, "m.stl");
  REQUIRE(result.ok());
  CHECK(result->mesh.triangles.size() == 3);
  CHECK(result->mesh.positions.size() == 9);
  CHECK(result->mesh.positions[8] == Vec3(0, 1.5, -0.2));
  CHECK(read("solid\r" + kAscii + "endsolid", "m.stl").ok());
}

TEST_CASE("stl: malformed ascii is refused with its line") {
  const auto broken = [](const std::string& from, const std::string& to) {
    std::string text = "solid\n" + kAscii + "endsolid\n";
    text.replace(text.find(from), from.size(), to);
    return refusal(text, "m.stl");
  };
  CHECK(contains(broken("vertex 1 0 0", "vertex 1 0"), "line 6 of 'a': 'vertex' is not a number"));
  CHECK(contains(broken("1.5", "1,5"), "line 6 of 'a': '1,5' is not a number"));
  CHECK(contains(broken("1.5", "1e999"), "line 6 of 'a': the coordinate '1e999' is not finite"));
  CHECK(contains(broken("  vertex 1 0 0\n", ""), "line 6 of 'a': expected 'vertex', found 'endloop'"));
  CHECK(contains(broken(" endloop\n", "  vertex 0 0 0\n endloop\n"), "expected 'endloop', found 'vertex'"));
  CHECK(contains(broken("endfacet\n", ""), "expected 'endfacet'"));
  CHECK(contains(broken("endsolid\n", ""), "truncated"));
  CHECK(contains(broken("endsolid\n", "endsolid\nfacet"), "expected 'solid', found 'facet'"));
  CHECK(code("solid x\nendsolid x\n", "m.stl") == ErrorCode::empty_mesh);
}

TEST_CASE("stl: the limits of vertices and triangles hold") {
  ReadLimits limits;
  limits.max_triangles = 1;
  const std::string ascii = "solid\n" + kAscii + kAscii + "endsolid\n";
  for (const std::string& file : {binary(kFacet + kFacet, 2), ascii}) {
    auto result = read(file, "m.stl", limits);
    REQUIRE(!result.ok());
    CHECK(result.error().code == ErrorCode::too_large);
  }
  limits = {};
  limits.max_vertices = 5;
  for (const std::string& file : {binary(kFacet + kFacet, 2), ascii}) {
    auto result = read(file, "m.stl", limits);
    REQUIRE(!result.ok());
    CHECK(result.error().code == ErrorCode::too_large);
  }
}

}  // namespace meshgauge::api::test
