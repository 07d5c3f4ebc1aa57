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
  CHECK(result->notes.polygons == 1);
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

TEST_CASE("off: malformed files are refused with their line") {
  const auto broken = [](const std::string& from, const std::string& to) {
    std::string text = kOff;
    text.replace(text.find(from), from.size(), to);
    return refusal(text, "m.off");
  };
  CHECK(contains(broken("4 2 0", "4 2000000 0"), "line 2 of 'a': 4 vertices and 2000000 faces do not fit"));
  CHECK(contains(broken("4 2 0", "-4 2 0"), "do not fit"));
  CHECK(contains(broken("4 2 0", "4 3 0"), "truncated"));
  CHECK(contains(broken("4 2 0", "4 1 0"), "line 8 of 'a': left-over text: the counts announce fewer lines"));
  CHECK(contains(broken("4 2 0", "3 2 0"), "line 6 of 'a': 0 is not a number of corners"));
  CHECK(contains(broken("4 2 0", "4"), "the line ends where an integer is expected"));
  CHECK(contains(broken("1.5", "1,5"), "line 6 of 'a': '1,5' is not a number"));
  CHECK(contains(broken("1.5", "nan"), "line 6 of 'a': the coordinate 'nan' is not finite"));
  CHECK(contains(broken("3 0 1 2", "3 0 1 4"), "line 7 of 'a': index 4"));
  CHECK(contains(broken("3 0 1 2", "3 0 1"), "line 7 of 'a': the line ends"));
  CHECK(contains(broken("3 0 1 2", "-3 0 1 2"), "-3 is not a number of corners"));
  for (const char* kind : {"4OFF", "NOFF", "STOFF", "nOFF"}) {
    CHECK(contains(broken("OFF", kind), "'" + std::string(kind) + "', which is not supported"));
  }
  CHECK(contains(refusal("OFF BINARY\n" + kOff, "m.off"), "binary OFF"));
  CHECK(contains(refusal("4 2 0\n", "m.off"), "begins with 'OFF'"));
}

}  // namespace meshgauge::api::test
