#include "api/formats/file/readers.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "api/formats/weld.h"
#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

// With `attributes` as the count of attribute bytes, which colours use otherwise.
std::string facet(const std::array<float, 9>& corners, float normal = 0, std::uint16_t attributes = 0xABAB) {
  std::string out = raw(normal) + raw(normal) + raw(normal);
  for (const float c : corners) out += raw(c);
  return out + raw(attributes);
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
  CHECK(contains(refusal(binary_stl(kFacet, 1) + std::string(81, 'x'), "m.stl"), "byte 134 of 'a': left-over"));
  CHECK(contains(refusal(binary_stl(kFacet, 1) + std::string(51, 'x'), "m.stl"), "byte 134 of 'a': left-over"));
  CHECK(contains(refusal(binary_stl("x", 0), "m.stl"), "byte 84 of 'a': left-over"));
  CHECK(contains(refusal(binary_stl(kFacet, 0xFFFFFFFF), "m.stl"), "truncated"));
  CHECK(contains(refusal(binary_stl(kFacet, 2, "solid"), "m.stl"), "truncated"));
  CHECK(contains(refusal(std::string("STL\0", 4), "m.stl"), "truncated"));
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

TEST_CASE("stl: corners merged while they are read are those that weld() merges, bit for bit") {
  const float values[] = {0.F, -0.F, 1.F, -1.F, 1e-30F, 3e38F};
  std::size_t next = 1;
  const auto any = [&] { return values[(next = next * 25214903917 + 11) / 65536 % std::size(values)]; };
  for (const std::size_t facets : {1U, 2U, 63U, 64U, 65U, 200U}) {
    std::string body;
    for (std::size_t i = 0; i < facets; ++i) {
      std::array<float, 9> corners{};
      std::ranges::generate(corners, any);
      body += facet(corners);
    }
    const std::string file = binary_stl(body, static_cast<std::uint32_t>(facets)) + "\n";
    auto apart = read(file, "m.stl");
    const auto merged = read(file, "m.stl", {}, api::Corners::merged);
    REQUIRE((apart.ok() && merged.ok()));
    CHECK(!apart->merged);
    CHECK(merged->merged);
    CHECK(merged->notes.remarks == apart->notes.remarks);
    CHECK(merged->notes.welded_vertices == weld(apart->mesh));
    CHECK(merged->mesh.triangles == apart->mesh.triangles);
    REQUIRE(merged->mesh.positions == apart->mesh.positions);
    CHECK(std::memcmp(merged->mesh.positions.data(), apart->mesh.positions.data(),
                      apart->mesh.positions.size() * sizeof(Vec3)) == 0);
    body.replace(body.size() - 6, 4, raw(std::numeric_limits<float>::infinity()));
    const std::string bad = binary_stl(body, static_cast<std::uint32_t>(facets));
    CHECK(refusal(bad, "m.stl") == "byte " + std::to_string(bad.size() - 6) + " of 'a': a coordinate of facet " +
                                       std::to_string(facets - 1) + " is not finite");
    CHECK(read(bad, "m.stl", {}, api::Corners::merged).error().message == refusal(bad, "m.stl"));
  }
}

TEST_CASE("stl: the limit of vertices counts the corners of a file, not what is left of them") {
  const std::string file = binary_stl(kFacet + kFacet, 2);
  const ReadLimits five{5, 100};
  CHECK(read(file, "m.stl", five, api::Corners::merged).error().message == "'a' has more vertices than the limit of 5");
  CHECK(read(file, "m.stl", ReadLimits{6, 100}, api::Corners::merged)->mesh.positions.size() == 3);
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

TEST_CASE("stl: up to 49 bytes after the last facet are ignored with a remark") {
  for (const std::size_t left : {1U, 2U, 48U, 49U}) {
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

TEST_CASE("stl: a count that differs from the whole facets of the file is refused with both") {
  const auto counted = [](std::uint32_t count, int facets) {
    std::string all;
    for (int i = 0; i < facets; ++i) all += facet(kCorners, 0, 0);
    return refusal(binary_stl(all, count, "OpenSCAD Model\n"), "m.stl");
  };
  CHECK(counted(0, 12) ==
        "byte 80 of 'a': the header counts 0 facets, the file holds 12: written to a pipe? Write it to a file, so that "
        "its header gets the count");
  CHECK(counted(11, 12) ==
        "byte 80 of 'a': the header counts 11 facets, the file holds 12: write it again, so that both agree");
  CHECK(contains(counted(1, 26), "the header counts 1 facets, the file holds 26: "));
  CHECK(counted(13, 12) ==
        "byte 684 of 'a': truncated: the count of 13 facets needs 734 bytes, the file has 684 and holds 12 facets");
  CHECK(contains(counted(0x2020202, 12), "bytes, the file has 684 and holds 12 facets"));
  CHECK(contains(counted(0xFFFFFFFF, 12), "and holds 12 facets"));
}

TEST_CASE("stl: attribute data after facets is refused, colours in its count are not") {
  const auto with_data = [](int facets, std::uint16_t count, std::size_t bytes) {
    std::string all;
    for (int i = 0; i < facets; ++i) all += facet(kCorners, 0, count) + std::string(bytes, 'a');
    return binary_stl(all, static_cast<std::uint32_t>(facets));
  };
  CHECK(
      refusal(with_data(12, 4, 4), "m.stl") ==
      "byte 134 of 'a': attribute data after facets, which is not supported: 48 bytes, the first after facet 0; export "
      "without attributes");
  CHECK(code(with_data(12, 4, 4), "m.stl") == ErrorCode::unsupported_format);
  for (const int facets : {1, 2, 24, 25, 50}) {
    for (const std::uint16_t bytes : std::to_array<std::uint16_t>({1, 2, 4, 50, 300})) {
      for (const char* tail : {"", "\n"}) {
        const std::string file = with_data(facets, bytes, bytes) + tail;
        INFO(facets << " facets of " << bytes << " bytes: " << refusal(file, "m.stl"));
        CHECK(code(file, "m.stl") == ErrorCode::unsupported_format);
      }
    }
  }
  const std::string last = binary_stl(facet(kCorners, 0, 0) + facet(kCorners, 0, 7) + "payload", 2);
  CHECK(contains(refusal(last, "m.stl"), "byte 184 of 'a': attribute data after facets"));
  for (const std::uint16_t colour : std::to_array<std::uint16_t>({1, 4, 50, 0x7C1F, 0xFFFF})) {
    const auto result = read(with_data(12, colour, 0), "m.stl");
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles.size() == 12);
    CHECK(result->notes.remarks.empty());
  }
  CHECK(read(with_data(12, 0x7C1F, 0) + "\n", "m.stl").ok());
}

TEST_CASE("stl: big-endian numbers are refused by name, where the count fits in that order alone") {
  std::string facets;
  for (int i = 0; i < 12; ++i) facets += kFacet;
  const std::string file = binary_stl(facets, std::uint32_t{12} << 24U);
  CHECK(
      refusal(file, "m.stl") ==
      "byte 80 of 'a': big-endian numbers, which are not supported: the count of 12 facets fits the file in that order "
      "alone; export it as little-endian, as STL asks");
  CHECK(code(file, "m.stl") == ErrorCode::unsupported_format);
  CHECK(code(file + "\n", "m.stl") == ErrorCode::unsupported_format);
  CHECK(contains(refusal(file + kFacet, "m.stl"), "truncated"));
}

TEST_CASE("stl: text whose first line is not 'solid' is refused by what it begins with") {
  const std::string solid = "solid a\n" + kAscii + "endsolid a\n";
  const std::string is_text = "line 1 of 'a': text, but line 1 is not 'solid': the file begins with ";
  CHECK(refusal("exported by x\n" + solid, "m.stl") == is_text + "'exported by x'; delete the lines before 'solid'");
  CHECK(refusal("# a comment\r\n" + solid, "m.stl") == is_text + "'# a comment'; delete the lines before 'solid'");
  CHECK(refusal("soild a\n" + kAscii, "m.stl") == is_text + "'soild a'; begin the file with a line 'solid'");
  CHECK(contains(refusal(kAscii, "m.stl"), "'facet normal 0 0 1'; begin the file with a line 'solid'"));
  CHECK(contains(refusal("\n\n ; c\n" + solid, "m.stl"), "line 3 of 'a': text, but line 1 is not 'solid'"));
  const std::string no_facets = "; it has no line that begins with 'facet': export it as STL";
  CHECK(refusal("404: not found\n", "m.stl") == is_text + "'404: not found'" + no_facets);
  CHECK(refusal("STL", "m.stl") == is_text + "'STL'" + no_facets);
  CHECK(contains(refusal("\xEF\xBB\xBF" + std::string("# c\n") + solid, "m.stl"), "the file begins with '# c'"));
  CHECK(code("exported by x\n" + solid, "m.stl") == ErrorCode::unreadable_mesh);
  CHECK(contains(refusal("solids\n" + kAscii, "m.stl"), "expected 'solid', found 'solids'"));
}

TEST_CASE("stl: ascii with a byte order mark, and with NUL or 0x1A bytes after its last line") {
  const std::string solid = "solid a\n" + kAscii + "endsolid a\n";
  const auto marked = read("\xEF\xBB\xBF" + solid, "m.stl");
  REQUIRE(marked.ok());
  CHECK(marked->mesh.triangles.size() == 1);
  CHECK(marked->notes.remarks.empty());
  CHECK(read("\xEF\xBB\xBF" + solid, "").ok());
  CHECK(contains(refusal("\xEF\xBB\xBFsolid\nx\n", "m.stl"), "line 2 of 'a': expected 'facet'"));
  for (const std::string& padding :
       {std::string(1, '\0'), std::string(kMostPadding, '\0'), std::string("\x1A"), std::string("\x1A\0\n\0\r\n", 6)}) {
    const auto padded = read(solid + padding, "m.stl");
    REQUIRE(padded.ok());
    CHECK(padded->mesh.triangles.size() == 1);
    CHECK(padded->notes.remarks == std::vector<std::string>{"NUL or 0x1A bytes after the last line, ignored"});
  }
  CHECK(!read(solid + std::string("\0x", 2), "m.stl"));
  CHECK(!read(solid + std::string(kMostPadding + 1, '\0'), "m.stl"));
  CHECK(!read("solid a\n" + kAscii + '\x1A' + kAscii, "m.stl"));
}

TEST_CASE("stl: ascii with control bytes is refused with their line") {
  CHECK(refusal(std::string("solid a\n\1\n") + kAscii + "endsolid a\n", "m.stl") ==
        "line 2 of 'a': binary data in a text file");
  CHECK(contains(refusal(std::string("solid a\0\n", 9) + kAscii, "m.stl"), "line 1 of 'a': binary data"));
}

TEST_CASE("stl: ascii whose endsolid is joined to the name ends the solid, with a remark") {
  const auto joined = read("solid AssimpScene\n" + kAscii + "endsolidAssimpScene\n", "m.stl");
  REQUIRE(joined.ok());
  CHECK(joined->mesh.triangles.size() == 1);
  CHECK(joined->notes.remarks == std::vector<std::string>{"endsolid joined to a name, read as the end of a solid: 1, "
                                                          "the first is 'endsolidAssimpScene'"});
  const auto two = read("solid a\n" + kAscii + "ENDSOLIDa b\nsolid c\n" + kAscii + "endsolidc", "m.stl");
  REQUIRE(two.ok());
  CHECK(two->mesh.triangles.size() == 2);
  CHECK(contains(two->notes.remarks.at(0), ": 2, the first is 'ENDSOLIDa'"));
  CHECK(!read("solid a\n" + kAscii + "endsolidfacet normal 0 0 1 outer loop\n", "m.stl"));
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

TEST_CASE("stl: no facet of ascii is passed over, however it is written and wherever it stands") {
  std::string line = kAscii;
  std::ranges::replace(line, '\n', ' ');
  const auto misspelt = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  for (const auto& [from, to] : {std::pair{"facet", "fcet"},
                                 {"facet normal", "facetnormal"},
                                 {"facet normal", "facet"},
                                 {"normal", "norml"},
                                 {"outer", "outr"},
                                 {"loop", "lop"},
                                 {"vertex", "vertx"},
                                 {"endloop", "endlop"},
                                 {"endfacet", "endfact"}}) {
    const std::string bad = misspelt(line, from, to);
    CAPTURE(bad);
    const auto one_more = [&](const std::string& file) {
      const auto result = read(file, "m.stl");
      return !result || result->mesh.triangles.size() == 2;
    };
    for (const char* end : {"\n", " "}) {
      CHECK(one_more("solid a" + std::string(end) + bad + end + kAscii + "endsolid a\n"));
      CHECK(one_more("solid a" + std::string(end) + line + end + bad + end + "endsolid a\n"));
      CHECK(one_more("solid a" + std::string(end) + line + end + "endsolid a" + end + bad));
      CHECK(one_more("solid a" + std::string(end) + line + end + "endsolid a" + end + bad + "solid b\nendsolid b\n"));
      CHECK(one_more("solid a" + std::string(end) + line + end + "endsolid a solid b " + bad + "endsolid b\n"));
    }
  }
  CHECK(contains(refusal("solid a " + misspelt(line, "facet", "fcet") + "\nendsolid a\n", "m.stl"),
                 "line 1 of 'a': 'vertex' in the name of a solid: a facet begins with 'facet normal'"));
  CHECK(contains(refusal("solid a\nfacet normal 0 0 1 2\n" + kAscii, "m.stl"), "expected 'outer', found '2'"));
  CHECK(read("solid vertex facet loop\n" + kAscii + "endsolid vertex facet loop\n", "m.stl").ok());
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
