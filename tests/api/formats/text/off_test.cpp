#include "api/formats/file/readers.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

const std::string kVertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1.5\n";
const std::string kOff = "OFF\n4 2 0\n" + kVertices + "3 0 1 2\n4 0 1 2 3\n";

void check_off(const std::string& file) {
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
  check_off(kOff);
  check_off("OFF 4 2 0\n" + kVertices + "3 0 1 2\n4 0 1 2 3");
  check_off("OFF # kind\n# counts\n\n4 2\n" + kVertices + "# faces\n3 0 1 2 255 0 0\n\n4 0 1 2 3 0.5 0.5 0.5 1\n");
  check_off(
      "COFF\r\n4 2 0\r\n0 0 0 1 1 1 1\r\n1 0 0 1 1 1 1\r\n0 1 0 1 1 1 1\r\n0 0 1.5 1 1 1 1\r\n3 0 1 2\r\n4 0 1 2 "
      "3\r\n");
}

TEST_CASE("off: normals, colours and texture coordinates of vertices are ignored") {
  const auto with = [](const std::string& keyword, const std::string& extras) {
    std::string text = keyword + "\n4 2 0\n";
    for (const char* vertex : {"0 0 0", "1 0 0", "0 1 0", "0 0 1.5"}) text += vertex + (" " + extras) + "\n";
    return text + "3 0 1 2\n4 0 1 2 3\n";
  };
  check_off(with("NOFF", "0 0 nan"));
  check_off(with("COFF", "0.5 0.5 0.5"));
  check_off(with("STOFF", "0.25 0.75 # a comment"));
  check_off(with("CNOFF", "0 0 1 255 0 0 255"));
  check_off(with("STCNOFF", "0 0 1 255 0 0 255 0.5 0.5"));
  check_off(with("NCSTOFF", "0 0 1 255 0 0 255 0.5 0.5"));
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
  CHECK(contains(broken("4 2 0", "4 3 0"),
                 "truncated: the counts announce 4 vertices and 3 faces, the file ends after 4 and 2"));
  CHECK(refusal("OFF # c\n#\n", "m.off") == "line 3 of 'a': truncated: the file ends before the counts");
  CHECK(contains(broken("4 2 0", "3 2 0"), "line 6 of 'a': 0 is not a number of corners"));
  CHECK(contains(broken("4 2 0", "4"), "the line ends where an integer is expected"));
  CHECK(contains(broken("1.5", "1,5"), "line 6 of 'a': '1,5' is not a number"));
  CHECK(contains(broken("1.5", "nan"), "line 6 of 'a': the coordinate 'nan' is not finite"));
  CHECK(contains(broken("3 0 1 2", "3 0 1 4"), "line 7 of 'a': index 4"));
  CHECK(contains(broken("3 0 1 2", "3 0 1"), "line 8 of 'a': index 4"));
  CHECK(contains(broken("4 0 1 2 3", "4 0 1 2"), "line 9 of 'a': truncated"));
  CHECK(contains(broken("3 0 1 2", "-3 0 1 2"), "-3 is not a number of corners"));
  CHECK(contains(broken("4 2 0", "4 1 0"),
                 "line 8 of 'a': left-over lines after the 1 faces that the counts announce: 1"));
  CHECK(contains(broken("4 2 0", "4 0 0"),
                 "line 7 of 'a': left-over lines after the 0 faces that the counts announce: 2"));
  check_off(kOff + "# the end\n\n");
  for (const char* kind : {"4OFF", "nOFF", "4nOFF", "NNOFF", "SOFF", "STCN4nOFF"}) {
    CHECK(contains(broken("OFF", kind), "'" + std::string(kind) + "', which is not supported"));
  }
  CHECK(contains(refusal("OFF BINARY\n" + kOff, "m.off"), "byte 11 of 'a': truncated or damaged"));
  CHECK(contains(refusal("4 2 0\n", "m.off"), "line 1 of 'a': 4 vertices and 2 faces do not fit"));
  for (const char* start : {"4\n", "4 2 0 1\n", "4 2 x\n", "4.5 2 0\n", "-4 2 0\n", "OF\n", "", "#"}) {
    CHECK(!read(start + kVertices, "m.off").ok());
  }
  CHECK(contains(refusal("# c\n4 2 x\n" + kVertices, "m.off"), "line 2 of 'a': an OFF file must begin with 'OFF'"));
}

TEST_CASE("off: the keyword after comments, blanks and a byte order mark, and close to the counts") {
  const std::string body = kOff.substr(4);
  check_off("# a comment OFF\n\n" + kOff);
  check_off("\xEF\xBB\xBF \t\r\n" + kOff);
  check_off("\t  OFF" + body);
  check_off("OFF4 2 0 # or so\n" + body.substr(6));
  const auto detected = [](const std::string& file) { return detect_format(bytes_of(file), {"a", "", ""}); };
  CHECK(detected("# c\n  OFF8 6 12\n") == Format::off);
  CHECK(detected("OFFICE 1 2 3\n") == std::nullopt);
  CHECK(detected("TAKEOFF\n") == std::nullopt);
  CHECK(detected("# OFF\nv 1 2 3\n") == Format::obj);
}

TEST_CASE("off: other objects of Geomview are refused by name") {
  const auto message = [](const std::string& word) {
    return "'a' begins with '" + word +
           "', another object of Geomview than OFF, which is not supported; save its faces as one OFF";
  };
  for (const char* word : {"LIST", "INST", "QUAD", "CQUAD", "CNQUAD", "POLY", "MESH", "CMESH", "ZuMESH", "BEZ133",
                           "BBP", "STBBP", "VECT", "4VECT", "TLIST", "SKEL", "SPHERE", "appearance"}) {
    for (const std::string& start : {std::string(), std::string("# c\n\t "), std::string("\xEF\xBB\xBF")}) {
      CAPTURE(start + word);
      CHECK(refusal(start + word + "\n1 2 3\n", "m.off") == message(word));
      CHECK(code(start + word + "\n1 2 3\n", "m.off") == ErrorCode::unsupported_format);
    }
  }
  CHECK(refusal("QUAD BINARY\n" + kVertices, "m.off") == message("QUAD"));
  for (const char* start : {"{ ", "{", "{\n# c\n", "{ appearance { +edge }\n", "{ = ", "{ LIST { "}) {
    for (const char* name : {"m.off", "m.gltf", ""}) CHECK(refusal(start + kOff + "}", name) == message("{"));
  }
  CHECK(contains(refusal("{\"OFF\": 1}", "m.off"), "asset"));  // a glTF, though not a good one
  CHECK(contains(refusal("LISTS\n", "m.off"), "an OFF file must begin with 'OFF'"));
}

TEST_CASE("off: NUL and 0x1A bytes after the last line are noted, in text") {
  using namespace std::string_literals;
  for (const std::string& end : {"\0"s, "\n\0\n"s, "\x1A"s}) {
    check_off(kOff + end);
    CHECK(read(kOff + end, "m.off")->notes.remarks ==
          std::vector<std::string>{"NUL or 0x1A bytes after the last line, ignored"});
    check_off(kOff.substr(4) + end);
    CHECK(read(kOff.substr(4) + end, "m.off")->notes.remarks.size() == 2);
    CHECK(!read(kOff + end + "3 0 1 2\n", "m.off").ok());
  }
}

TEST_CASE("off: faces over several lines") {
  const std::string head = "OFF\n4 2 0\n" + kVertices;
  check_off(head + "3 0 1\n2\n4\n0\n\n1 # a comment\n 2\n# another\n3 0.5 0.5\n");
}

TEST_CASE("off: without a keyword, if the name says OFF") {
  const std::string file = "# no keyword\n" + kOff.substr(4);
  check_off(file);
  CHECK(contains(read(file, "m.off")->notes.remarks.at(0), "the keyword OFF is missing"));
  CHECK(contains(refusal(file, ""), "has an unknown format"));
  CHECK(read(kOff, "m.off")->notes.remarks.empty());
}

namespace {

template <class T>
std::string word(T value, bool big_endian) {
  std::string out = raw(value);
  if (big_endian) std::ranges::reverse(out);
  return out;
}

// The mesh of kOff in any variant of binary OFF.
std::string binary_off(bool big_endian, bool colours, const std::string& keyword = "OFF", int extras = 0) {
  std::string out = keyword + " BINARY\n";
  for (const std::uint32_t count : {4U, 2U, 0U}) out += word(count, big_endian);
  for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.5F}) {
    out += word(x, big_endian);
    static int k = 0;
    if (++k % 3 != 0) continue;
    for (int i = 0; i < extras; ++i) out += word(0.25F, big_endian);
  }
  for (const std::vector<std::uint32_t>& face : {std::vector<std::uint32_t>{0, 1, 2}, {0, 1, 2, 3}}) {
    out += word(static_cast<std::uint32_t>(face.size()), big_endian);
    for (const std::uint32_t corner : face) out += word(corner, big_endian);
    if (colours) out += word(std::uint32_t{1}, big_endian) + word(0.5F, big_endian);
  }
  return out;
}

}  // namespace

TEST_CASE("off: binary, as Geomview writes it and as others do") {
  check_off(binary_off(true, true));
  CHECK(read(binary_off(true, true), "m.off")->notes.remarks.empty());
  for (const bool big_endian : {true, false}) {
    for (const bool colours : {true, false}) {
      const std::string file = binary_off(big_endian, colours);
      check_off(file);
      CHECK(read(file, "")->notes.remarks.size() == (big_endian && colours ? 0 : 1));
    }
  }
  check_off(binary_off(true, true, "NOFF", 3));
  check_off(binary_off(true, true, "COFF", 4));
  check_off(binary_off(false, false, "STCNOFF", 9));
  CHECK(contains(refusal(binary_off(true, true, "4OFF"), "m.off"), "'4OFF', which is not supported"));
}

TEST_CASE("off: binary files that are cut, changed or beyond a limit") {
  for (const bool way : {true, false}) {
    const std::string file = binary_off(way, way);
    for (std::size_t kept = 11; kept < file.size(); ++kept) {
      CAPTURE(kept);
      CHECK(code(file.substr(0, kept), "m.off") == ErrorCode::unreadable_mesh);
    }
    CHECK(!read(file + "x", "m.off").ok());
    for (std::size_t at = 11; at < file.size(); ++at) {
      for (unsigned bit = 0; bit < 8; ++bit) {
        std::string changed = file;
        changed[at] = static_cast<char>(changed[at] ^ (1 << bit));
        const auto result = read(changed, "m.off");
        if (result) CHECK(result->mesh.positions.size() == 4);
      }
    }
  }
  std::string nan = binary_off(true, true);
  nan.replace(11 + 12 + 4, 4, word(std::numeric_limits<float>::quiet_NaN(), true));
  CHECK(contains(refusal(nan, "m.off"), "byte 27 of 'a': a coordinate of vertex 0 is not finite"));
  ReadLimits limits;
  limits.max_triangles = 2;
  CHECK(read(binary_off(true, true), "m.off", limits).error().code == ErrorCode::too_large);
  limits = {};
  limits.max_vertices = 3;
  CHECK(read(binary_off(true, true), "m.off", limits).error().code == ErrorCode::too_large);
}

}  // namespace meshgauge::api::test
