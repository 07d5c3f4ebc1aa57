#include "api/formats/off.h"

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

const std::string kVertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1.5\n";
const std::string kOff = "OFF\n4 2 0\n" + kVertices + "3 0 1 2\n4 0 1 2 3\n";

void check_mesh(const std::string& file) {
  auto result = read(file, "m.off");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  CHECK(result->format == Format::off);
  CHECK(result->mesh.positions.at(3) == Vec3(0, 0, 1.5));
  CHECK(result->mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
  CHECK(result->notes.polygons.count == 1);
}

}  // namespace

TEST_CASE("off: comments, blank lines, colours and a count on the first line") {
  check_mesh(kOff);
  check_mesh("OFF 4 2 0\n" + kVertices + "3 0 1 2\n4 0 1 2 3");
  check_mesh("OFF # kind\n# counts\n\n4 2\n" + kVertices + "# faces\n3 0 1 2 255 0 0\n\n4 0 1 2 3 0.5 0.5 0.5 1\n");
  check_mesh(
      "COFF\r\n4 2 0\r\n0 0 0 1 1 1 1\r\n1 0 0 1 1 1 1\r\n0 1 0 1 1 1 1\r\n0 0 1.5 1 1 1 1\r\n3 0 1 2\r\n4 0 1 2 "
      "3\r\n");
}

TEST_CASE("off: normals, colours and texture coordinates of vertices are passed over") {
  const auto with = [](const std::string& keyword, const std::string& extras) {
    std::string text = keyword + "\n4 2 0\n";
    for (const char* vertex : {"0 0 0", "1 0 0", "0 1 0", "0 0 1.5"}) text += vertex + (" " + extras) + "\n";
    return text + "3 0 1 2\n4 0 1 2 3\n";
  };
  check_mesh(with("NOFF", "0 0 nan"));
  check_mesh(with("COFF", "0.5 0.5 0.5"));
  check_mesh(with("STOFF", "0.25 0.75 # a comment"));
  check_mesh(with("CNOFF", "0 0 1 255 0 0 255"));
  check_mesh(with("STCNOFF", "0 0 1 255 0 0 255 0.5 0.5"));
  check_mesh(with("NCSTOFF", "0 0 1 255 0 0 255 0.5 0.5"));
  const std::string expected = "line 3 of 'a': the line ends where a normal, colour or texture coordinate is expected";
  CHECK(contains(refusal(with("NOFF", "0 1"), "m.off"), expected));
  CHECK(contains(refusal(with("NOFF", "0 1 # 0"), "m.off"), expected));
  CHECK(contains(refusal(with("STNOFF", "0 0 1 0.5"), "m.off"), expected));
}

TEST_CASE("off: the limits of vertices and triangles hold") {
  ReadLimits limits;
  limits.max_triangles = 2;
  auto triangles = read(kOff, "m.off", limits);
  REQUIRE(!triangles.ok());
  CHECK(triangles.error().code == ErrorCode::too_large);
  limits = {};
  limits.max_vertices = 3;
  auto vertices = read(kOff, "m.off", limits);
  REQUIRE(!vertices.ok());
  CHECK(vertices.error().code == ErrorCode::too_large);
}

TEST_CASE("off: malformed files are refused with their line") {
  const auto broken = [](const std::string& from, const std::string& to) {
    std::string text = kOff;
    text.replace(text.find(from), from.size(), to);
    return refusal(text, "m.off");
  };
  CHECK(contains(broken("4 2 0", "4 2000000 0"), "line 2 of 'a': 4 vertices and 2000000 faces do not fit"));
  CHECK(contains(broken("4 2 0", "-4 2 0"), "do not fit"));
  CHECK(contains(broken("4 2 0", "4 3 0"), "truncated"));
  CHECK(contains(broken("4 2 0", "3 2 0"), "line 6 of 'a': 0 is not a number of corners"));
  CHECK(contains(broken("4 2 0", "4"), "the line ends where an integer is expected"));
  CHECK(contains(broken("1.5", "1,5"), "line 6 of 'a': '1,5' is not a number"));
  CHECK(contains(broken("1.5", "nan"), "line 6 of 'a': the coordinate 'nan' is not finite"));
  CHECK(contains(broken("3 0 1 2", "3 0 1 4"), "line 7 of 'a': index 4"));
  CHECK(contains(broken("3 0 1 2", "3 0 1"), "line 7 of 'a': the line ends"));
  CHECK(contains(broken("3 0 1 2", "-3 0 1 2"), "-3 is not a number of corners"));
  CHECK(contains(broken("4 2 0", "4 1 0"), "line 8 of 'a': left-over lines after the 1 faces"));
  check_mesh(kOff + "# the end\n\n");
  for (const char* kind : {"4OFF", "nOFF", "4nOFF", "NNOFF", "SOFF", "STCN4nOFF"}) {
    CHECK(contains(broken("OFF", kind), "'" + std::string(kind) + "', which is not supported"));
  }
  CHECK(contains(refusal("OFF BINARY\n" + kOff, "m.off"), "binary OFF"));
  CHECK(contains(refusal("4 2 0\n", "m.off"), "begins with 'OFF'"));
}

}  // namespace meshgauge::api::test
