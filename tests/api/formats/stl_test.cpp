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

std::string binary_stl(const std::string& facets, std::uint32_t count, std::string header = "made by a test") {
  header.resize(80, '\0');
  return header + raw(count) + facets;
}

const std::array<float, 9> kCorners = {0, 0, 0, 1, 0, 0, 0, 1.1F, -0.0F};
const std::string kFacet = facet(kCorners);
const std::string kAscii =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1.5 -2e-1\n endloop\nendfacet\n";

}  // namespace

TEST_CASE("stl: a binary file gives exactly three vertices for each facet") {
  auto result = read(binary_stl(kFacet + kFacet, 2), "m.stl");
  REQUIRE(result.ok());
  CHECK(result->format == Format::stl);
  CHECK(result->mesh.positions.size() == 6);
  CHECK(result->mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}});
  CHECK(result->mesh.positions[2] == Vec3(0, static_cast<double>(1.1F), 0));
}

TEST_CASE("stl: binary is recognised by its size, for any header and name") {
  for (const char* header : {"solid", "solid part one", "solid x\nfacet normal 0 0 1\n", "", "v 1 2 3"}) {
    for (const char* name : {"m.stl", "m.obj", ""}) {
      auto result = read(binary_stl(kFacet, 1, header), name);
      REQUIRE(result.ok());
      CHECK(result->format == Format::stl);
      CHECK(result->mesh.triangles.size() == 1);
    }
  }
}

TEST_CASE("stl: normals are ignored") {
  CHECK(read(binary_stl(facet(kCorners, std::numeric_limits<float>::quiet_NaN()), 1), "m.stl").ok());
  std::string text = "solid\n" + kAscii + "endsolid\n";
  text.replace(text.find("0 0 1"), 5, "nan nan nan");
  CHECK(read(text, "m.stl").ok());
}

TEST_CASE("stl: a binary file of any other size is refused") {
  CHECK(contains(refusal(binary_stl(kFacet, 2), "m.stl"), "truncated: the count of 2 facets needs 184 bytes"));
  CHECK(contains(refusal(binary_stl(kFacet + kFacet + kFacet, 1), "m.stl"), "left-over bytes: the count of 1 facets"));
  CHECK(contains(refusal(binary_stl(kFacet, 1) + std::string(81, 'x'), "m.stl"), "byte 134 of 'a': left-over"));
  CHECK(contains(refusal(binary_stl("x", 0), "m.stl"), "byte 84 of 'a': left-over"));
  CHECK(contains(refusal(binary_stl(kFacet, 0xFFFFFFFF), "m.stl"), "truncated"));
  CHECK(contains(refusal(binary_stl(kFacet, 2, "solid"), "m.stl"), "truncated"));
  CHECK(contains(refusal("STL", "m.stl"), "truncated"));
  CHECK(code(binary_stl("", 0), "m.stl") == ErrorCode::empty_mesh);
}

TEST_CASE("stl: coordinates that are not finite are refused with their byte") {
  for (std::size_t k = 0; k < 9; ++k) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
      auto corners = kCorners;
      corners[k] = bad;
      const std::string file = binary_stl(kFacet + facet(corners), 2);
      CHECK(code(file, "m.stl") == ErrorCode::non_finite_vertex);
      CHECK(contains(refusal(file, "m.stl"), "byte " + std::to_string(84 + 50 + 12 + 4 * k) + " of 'a'"));
    }
  }
  auto corners = kCorners;
  corners[3] = std::numeric_limits<float>::max();
  CHECK(read(binary_stl(facet(corners), 1), "m.stl").ok());
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

TEST_CASE("stl: up to 80 bytes after the last facet are ignored with a remark") {
  for (const std::size_t left : {1U, 2U, 49U, 50U, 80U}) {
    for (const char* header : {"", "solid x"}) {
      for (const char* name : {"m.stl", ""}) {
        const auto result = read(binary_stl(kFacet + kFacet, 2, header) + std::string(left, '\n'), name);
        REQUIRE(result.ok());
        CHECK(result->mesh.triangles.size() == 2);
        CHECK(result->notes.remarks ==
              std::vector<std::string>{"bytes after the last of the 2 facets that the header announces, ignored: " +
                                       std::to_string(left)});
      }
    }
  }
  CHECK(read(binary_stl(kFacet, 1), "m.stl")->notes.remarks.empty());
}

TEST_CASE("stl: ascii that ends after a facet, without endsolid, gets a remark") {
  for (const std::string& file : {"solid x\n" + kAscii, "solid x\n" + kAscii + kAscii + "\n \n",
                                  "solid x\n" + kAscii + "endsolid x\nsolid y\n" + kAscii}) {
    const auto result = read(file, "m.stl");
    REQUIRE(result.ok());
    CHECK(result->notes.remarks.size() == 1);
    CHECK(contains(result->notes.remarks.at(0), "without endsolid"));
  }
  CHECK(read("solid x\n" + kAscii + "endsolid", "m.stl")->notes.remarks.empty());
}

TEST_CASE("stl: ascii whose lines are joined") {
  const auto joined = [](std::string text) {
    std::ranges::replace(text, '\n', ' ');
    return text;
  };
  const auto triangles = [](const std::string& file) {
    const auto result = read(file, "m.stl");
    INFO((result ? "" : result.error().message));
    REQUIRE(result.ok());
    return result->mesh.triangles.size();
  };
  const std::string one = "solid x\n" + kAscii + kAscii + "endsolid x\n";
  CHECK(triangles(joined(one)) == 2);
  CHECK(triangles(joined("solid a facet of it\n" + kAscii + "endsolid a facet of it\n" + one)) == 3);
  CHECK(triangles(joined(one + one) + "\n" + one) == 6);
  CHECK(triangles("solid facet\n" + kAscii + "endsolid solid\n" + one) == 3);
  CHECK(triangles(joined("solid\n" + kAscii + "endsolid\n")) == 1);
  CHECK(contains(refusal(joined(one + kAscii), "m.stl"), "expected 'solid', found 'facet'"));
  std::string hostile = "solid";
  for (int i = 0; i < 200'000; ++i) hostile += " endsolid solid";
  CHECK(!read(hostile, "m.stl").ok());
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
  CHECK(contains(broken("endfacet\nendsolid\n", ""), "truncated"));
  CHECK(contains(broken("endsolid\n", "endsoli"), "expected 'facet' or 'endsolid', found 'endsoli'"));
  CHECK(contains(refusal("solid x\n", "m.stl"), "truncated"));
  CHECK(contains(refusal("solid x\n" + kAscii + "endsolid\nsolid y\n", "m.stl"), "truncated"));
  CHECK(contains(broken("endsolid\n", "endsolid\nfacet"), "expected 'solid', found 'facet'"));
  CHECK(code("solid x\nendsolid x\n", "m.stl") == ErrorCode::empty_mesh);
}

TEST_CASE("stl: the limits of vertices and triangles hold") {
  ReadLimits limits;
  limits.max_triangles = 1;
  const std::string ascii = "solid\n" + kAscii + kAscii + "endsolid\n";
  for (const std::string& file : {binary_stl(kFacet + kFacet, 2), ascii}) {
    auto result = read(file, "m.stl", limits);
    REQUIRE(!result.ok());
    CHECK(result.error().code == ErrorCode::too_large);
  }
  limits = {};
  limits.max_vertices = 5;
  for (const std::string& file : {binary_stl(kFacet + kFacet, 2), ascii}) {
    auto result = read(file, "m.stl", limits);
    REQUIRE(!result.ok());
    CHECK(result.error().code == ErrorCode::too_large);
  }
}

}  // namespace meshgauge::api::test
