#include "api/formats/file/readers.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "tests/api/formats/files.h"
#include "tests/fuzz/dice.h"

namespace meshgauge::api::test {
namespace {

using fuzz::Dice;

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made by a test\n" + elements + "end_header\n";
}

const std::string kVertexElement = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "element face 2\nproperty list uchar int vertex_indices\n";
const std::string kAsciiBody = "0 0 0\n1 0 0\n0 1 0\n0 0 1.5\n3 0 1 2\n4 0 1 2 3\n";

template <class T>
std::string ordered(T value, bool big) {
  std::string bytes = raw(value);
  if (big) std::ranges::reverse(bytes);
  return bytes;
}

template <class Number, class Count, class Index>
std::string binary_body(bool big) {
  std::string body;
  for (const double c : {0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.5}) body += ordered(static_cast<Number>(c), big);
  for (const int length : {3, 4}) {
    body += ordered(static_cast<Count>(length), big);
    for (int i = 0; i < length; ++i) body += ordered(static_cast<Index>(i), big);
  }
  return body;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

void check_ply(const std::string& file) {
  auto result = read(file, "m.ply");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  CHECK(result->format == Format::ply);
  REQUIRE(result->mesh.positions.size() == 4);
  CHECK(result->mesh.positions[1] == Vec3(1, 0, 0));
  CHECK(result->mesh.positions[3] == Vec3(0, 0, 1.5));
  CHECK(result->mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
  CHECK(result->notes.polygons.count == 1);
}

const std::string kAsciiFile = header("ascii", kVertexElement + kFaces) + kAsciiBody;
const std::string kLittle =
    header("binary_little_endian", kVertexElement + kFaces) + binary_body<float, std::uint8_t, std::int32_t>(false);

template <class Wide>
void append_as(std::string& big, std::string& little, const std::string& type, Wide value) {
  const auto both = [&](auto number) { big += ordered(number, true), little += ordered(number, false); };
  if (type == "float") return both(static_cast<float>(value));
  if (type == "double") return both(static_cast<double>(value));
  if (type == "uchar") return both(static_cast<std::uint8_t>(value));
  if (type == "ushort") return both(static_cast<std::uint16_t>(value));
  both(static_cast<std::uint32_t>(value));
}

// Returns a file in both byte orders, mostly of triangles, with a few of the defects that a body can have.
std::pair<std::string, std::string> any_ply(Dice& dice) {
  const std::string real = dice.chance(0.5) ? "float" : "double";
  const char* const lengths[] = {"uchar", "ushort", "int", "uint"};
  const char* const kinds[] = {"ushort", "int", "uint", "int"};
  const std::string length = dice.pick(lengths), index = dice.pick(kinds), other = dice.chance(0.3) ? "uchar" : "";
  const int vertices = dice.between(3, 8), faces = dice.between(1, 12);
  const auto scalar = [&](const char* name) { return other.empty() ? "" : "property " + other + " " + name + "\n"; };
  std::string elements = "element vertex " + std::to_string(vertices) + "\n" + scalar("a");
  for (const char* axis : {"x", "y", "z"}) elements += "property " + real + " " + axis + "\n";
  elements += "element face " + std::to_string(faces) + "\n" + scalar("b");
  elements += "property list " + length + " " + index + " vertex_indices\n" + scalar("c");
  std::string big, little;
  const auto others = [&] {
    if (!other.empty()) append_as(big, little, other, 3);
  };
  for (int i = 0; i < vertices; ++i) {
    others();
    for (int k = 0; k < 3; ++k) {
      const double c = dice.chance(0.1) ? -0.0 : dice.uniform(-9, 9);
      append_as(big, little, real, dice.chance(0.005) ? std::numeric_limits<double>::quiet_NaN() : c);
    }
  }
  for (int i = 0; i < faces; ++i) {
    others();
    const int corners = dice.chance(0.85) ? 3 : dice.between(dice.chance(0.1) ? 0 : 1, 5);
    append_as(big, little, length, corners);
    for (int k = 0; k < corners; ++k)
      append_as(big, little, index, dice.between(dice.chance(0.01) ? -1 : 0, vertices - (dice.chance(0.99) ? 1 : 0)));
    others();
  }
  const std::size_t cut = dice.chance(0.1) ? dice.below(20) : 0;
  big.resize(big.size() - cut), little.resize(little.size() - cut);
  return {header("binary_big_endian", elements) + big, header("binary_little_endian", elements) + little};
}

}  // namespace

TEST_CASE("ply: all encodings and types give the same mesh") {
  check_ply(kAsciiFile);
  check_ply(kLittle);
  check_ply(header("binary_big_endian", kVertexElement + kFaces) +
            binary_body<float, std::uint8_t, std::int32_t>(true));
  std::string vertices = kVertexElement;
  while (contains(vertices, "float ")) vertices = replaced(vertices, "float ", "double ");
  const std::string faces = replaced(kFaces, "list uchar int", "list uint16 uint8");
  check_ply(header("binary_little_endian", vertices + faces) + binary_body<double, std::uint16_t, std::uint8_t>(false));
  check_ply(header("binary_big_endian", vertices + faces) + binary_body<double, std::uint16_t, std::uint8_t>(true));
  const std::string singular = replaced(kFaces, "list uchar int vertex_indices", "list int uint vertex_index");
  check_ply(header("binary_big_endian", vertices + singular) + binary_body<double, std::int32_t, std::uint32_t>(true));
}

TEST_CASE("ply: line ends of the header and of the text") {
  std::string crlf;
  std::string cr;
  for (const char c : kAsciiFile) {
    crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    cr += c == '\n' ? '\r' : c;
  }
  check_ply(crlf);
  check_ply(cr);
  check_ply(replaced(kLittle, "end_header\n", "end_header\r\n"));
  check_ply(replaced(kAsciiFile, "ascii 1.0", "ascii 1.0   "));
  check_ply(kAsciiFile + "\n \n");
  check_ply(kLittle + "\n");
}

TEST_CASE("ply: elements and properties that are no surface are ignored") {
  const std::string extra =
      "element camera 2\nproperty list uchar double m\nproperty short s\nelement none 4000000000\n";
  check_ply(header("ascii", extra + kVertexElement + kFaces) + "0 1\n2 nan x 5\n" + kAsciiBody);
  const std::string records = ordered<std::uint8_t>(0, true) + ordered<std::int16_t>(1, true) +
                              ordered<std::uint8_t>(1, true) + ordered(0.5, true) + ordered<std::int16_t>(1, true);
  check_ply(header("binary_big_endian", extra + kVertexElement + kFaces) + records +
            binary_body<float, std::uint8_t, std::int32_t>(true));
  const std::string coloured = replaced(kVertexElement, "property float z\n", "property uchar red\nproperty float z\n");
  check_ply(header("ascii", coloured + kFaces) +
            "0 0 7 0\n1 0 7 0\n0 1 7 0\n0 0 7 1.5 9 9 9\n3 0 1 2 255 0 0\n4 0 1 2 3\n");
  check_ply(header("ascii", replaced(kFaces, "face 2", "face 2") + kVertexElement) +
            "3 0 1 2\n4 0 1 2 3\n0 0 0\n1 0 0\n0 1 0\n0 0 1.5\n");
}

TEST_CASE("ply: elements that may be surface are noted, or refused where there is no other") {
  const std::string unread = "not read and not measured, though part of the surface: ";
  const auto remarks = [](const std::string& elements, const std::string& records) {
    auto result = read(header("ascii", kVertexElement + kFaces + elements) + kAsciiBody + records, "m.ply");
    INFO((result ? "" : result.error().message));
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles.size() == 3);
    return result->notes.remarks;
  };
  const std::string list = "property list uchar int vertex_indices\n";
  const std::string corners = "property int a\nproperty int b\nproperty int c\n";
  for (const std::string name : {"polygon", "Face", "faces", "triangle_fans", "range_grid", "anything", "polyface"}) {
    CHECK(remarks("element " + name + " 2\n" + list, "3 0 1 2\n3 0 1 3\n") ==
          std::vector<std::string>{unread + "elements '" + name + "': 2"});
  }
  for (const std::string name : {"triangle", "Quads", "tetra", "cell", "face_of_hull"}) {
    CHECK(remarks("element " + name + " 1\n" + corners, "0 1 2\n") ==
          std::vector<std::string>{unread + "elements '" + name + "': 1"});
  }
  CHECK(remarks("element e 1\nproperty int vertex1\nproperty int vertex2\nproperty int vertex3\n", "0 1 2\n") ==
        std::vector<std::string>{unread + "elements 'e': 1"});
  CHECK(remarks("element bezier 1\nproperty list uchar float points\n", "3 0 1 2\n") ==
        std::vector<std::string>{unread + "elements 'bezier': 1"});
  CHECK(remarks("element polygon 1\n" + list + "element cell 1\n" + corners, "3 0 1 2\n0 1 2\n").size() == 2);
  CHECK(remarks("element polygon 0\n" + list, "").empty());
  CHECK(remarks("element materials 1\nproperty list uchar int ids\nelement sensor 1\nproperty int a\nproperty int b\n",
                "1 7\n0 1\n")
            .empty());
  CHECK(remarks("element multi_texture_face 1\nproperty uchar tx\nproperty list uchar int texture_vertex_indices\n"
                "element tint 1\nproperty uchar r\nproperty uchar g\nproperty uchar b\n",
                "0 3 0 1 2\n1 2 3\n")
            .empty());
  CHECK(read(header("ascii", kVertexElement + "element triangles 0\n" + corners) + kAsciiBody.substr(0, 26), "m.ply")
            ->notes.cloud);

  const std::string only =
      header("ascii", kVertexElement + "element triangle 1\n" + corners) + kAsciiBody.substr(0, 26) + "0 1 2\n";
  CHECK(refusal(only, "m.ply") ==
        "'a' has no triangles, only what is not read (elements 'triangle': 1): export it as triangles");
  CHECK(code(only, "m.ply") == ErrorCode::unsupported_format);
  CHECK(contains(
      refusal(header("ascii", kVertexElement + "element polygon 1\n" + list) + kAsciiBody.substr(0, 26), "m.ply"),
      "truncated"));
}

TEST_CASE("ply: lists of faces and strips that may hold corners are noted") {
  const std::string unread = "not read and not measured, though part of the surface: ";
  const auto remarks = [](const std::string& lists, const std::string& values) {
    const std::string faces = "element face 2\nproperty list uchar int vertex_indices\n" + lists;
    auto result = read(header("ascii", kVertexElement + faces) + kAsciiBody.substr(0, 26) + "3 0 1 2" + values +
                           "\n3 0 1 3" + values + "\n",
                       "m.ply");
    INFO((result ? "" : result.error().message));
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles.size() == 2);
    return result->notes.remarks;
  };
  CHECK(remarks("property list uchar int holes\n", " 3 0 1 2") ==
        std::vector<std::string>{unread + "lists 'holes' of element 'face': 2"});
  CHECK(remarks("property list uchar int vertex_index\n", " 3 0 1 2") ==
        std::vector<std::string>{unread + "lists 'vertex_index' of element 'face': 2"});
  CHECK(remarks("property list uchar int holes\n", " 0").empty());
  CHECK(remarks("property list uchar float texcoord\nproperty int texnumber\n", " 2 0.5 1 7").empty());
  CHECK(remarks("property list uchar int Texture_indices\nproperty list uchar uchar colours\n", " 1 2 1 3").empty());
  const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\nproperty list int int more\n";
  const auto strip =
      read(header("ascii", kVertexElement + strips) + kAsciiBody.substr(0, 26) + "3 0 1 2 1 9\n", "m.ply");
  REQUIRE(strip.ok());
  CHECK(strip->notes.remarks == std::vector<std::string>{unread + "lists 'more' of element 'tristrips': 1"});
}

TEST_CASE("ply: edges beside faces are counted as left out") {
  for (const char* name : {"edge", "line", "Polylines"}) {
    const std::string edges = "element " + std::string(name) + " 2\nproperty int vertex1\nproperty int vertex2\n";
    const auto result = read(header("ascii", kVertexElement + kFaces + edges) + kAsciiBody + "0 1\n1 2\n", "m.ply");
    REQUIRE(result.ok());
    CHECK(result->notes.skipped_primitives == 2);
    CHECK(result->notes.remarks.empty());
  }
}

TEST_CASE("ply: lines with more values than announced get a remark: one may be a second face") {
  const auto result =
      read(replaced(replaced(kAsciiFile, "3 0 1 2\n", "3 0 1 2 3 0 1 3 \r\n"), "1.5", "1.5 9"), "m.ply");
  REQUIRE(result.ok());
  CHECK(result->notes.remarks ==
        std::vector<std::string>{"lines with more values than the header announces, the others ignored: 2"});
}

TEST_CASE("ply: a byte order mark, and NUL or 0x1A bytes after the last line") {
  check_ply("\xEF\xBB\xBF" + kAsciiFile);
  check_ply("\xEF\xBB\xBF" + kLittle);
  CHECK(read("\xEF\xBB\xBF" + kAsciiFile, "")->notes.remarks.empty());
  for (const std::string& padding :
       {std::string(1, '\0'), std::string(3000, '\0'), std::string("\x1A"), std::string("\n\x1A\0\r\n", 5)}) {
    check_ply(kAsciiFile + padding);
    CHECK(read(kAsciiFile + padding, "m.ply")->notes.remarks ==
          std::vector<std::string>{"NUL or 0x1A bytes after the last line, ignored"});
    CHECK(contains(refusal(kLittle + padding, "m.ply"), "left-over bytes"));
  }
  CHECK(contains(refusal(kAsciiFile + std::string("\0x", 2), "m.ply"), "left-over text"));
  // Padding that begins within the header's last line.
  const std::string bare = header("ascii", kVertexElement);
  CHECK(contains(refusal(bare.substr(0, bare.size() - 1) + std::string(" \0\n", 3), "m.ply"), "before end_header"));
}

TEST_CASE("ply: a file whose first line is not 'ply' is refused, whatever its name") {
  CHECK(refusal(replaced(kAsciiFile, "ply\n", "# a scan\n"), "m.ply") ==
        "line 1 of 'a': PLY header: line 1 is not 'ply' but '# a scan'");
  CHECK(contains(refusal(replaced(kAsciiFile, "ply\n", "plyx\n"), "m.ply"), "line 1 is not 'ply' but 'plyx'"));
  CHECK(contains(refusal(replaced(kAsciiFile, "ply\n", ""), "m.ply"), "not 'ply' but 'format ascii 1.0'"));
  CHECK(contains(refusal(std::string("\0\x01\x02", 3), "m.ply"), "line 1 is not 'ply' but '?"));
  CHECK(contains(refusal("ply", "m.ply"), "the file ends before end_header"));
}

TEST_CASE("ply: triangle strips, several in one list") {
  const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\n";
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1.5\n";
  // Two strips, the second made of two joined by a repeated corner; two more are too short for a surface.
  const std::string list = "15 0 1 2 3 -1 3 2 0 0 1 1 -1 0 1 -1\n";
  const std::vector<Triangle> expected = {{0, 1, 2}, {1, 3, 2}, {3, 2, 0}};
  const auto ascii = read(header("ascii", kVertexElement + strips) + vertices + list, "m.ply");
  REQUIRE(ascii.ok());
  CHECK(ascii->mesh.triangles == expected);
  CHECK(ascii->notes.skipped_primitives == 3 + 1);
  CHECK(ascii->notes.polygons.count == 0);

  std::string body = binary_body<float, std::uint8_t, std::int32_t>(true).substr(0, 4 * 12);
  body += ordered<std::int32_t>(15, true);
  for (const std::int32_t i : {0, 1, 2, 3, -1, 3, 2, 0, 0, 1, 1, -1, 0, 1, -1}) body += ordered(i, true);
  const auto binary = read(header("binary_big_endian", kVertexElement + strips) + body, "m.ply");
  REQUIRE(binary.ok());
  CHECK(binary->mesh.triangles == expected);

  const auto both = read(header("ascii", kVertexElement + kFaces + strips) + kAsciiBody + list, "m.ply");
  REQUIRE(both.ok());
  CHECK(both->mesh.triangles.size() == 3 + 3);
  CHECK(contains(refusal(header("ascii", kVertexElement + strips) + vertices + "3 0 1 -2\n", "m.ply"), "index -2"));
  CHECK(contains(refusal(header("ascii", kVertexElement + strips) + vertices + "3 0 1 4\n", "m.ply"), "index 4, but"));
  CHECK(code(header("ascii", kVertexElement + strips) + vertices + "3 0 1 -1\n", "m.ply") == ErrorCode::empty_mesh);
  ReadLimits limits;
  limits.max_triangles = 2;
  auto limited = read(header("ascii", kVertexElement + strips) + vertices + list, "m.ply", limits);
  REQUIRE(!limited.ok());
  CHECK(limited.error().code == ErrorCode::too_large);
}

TEST_CASE("ply: header lines that begin with an unknown word are ignored with a remark") {
  const auto with = [](const std::string& lines) {
    auto result = read(replaced(kAsciiFile, "element face", lines + "element face"), "m.ply");
    INFO((result ? "" : result.error().message));
    REQUIRE(result.ok());
    CHECK(result->mesh.positions.size() == 4);
    return result->notes.remarks;
  };
  CHECK(with("comment x\nobj_info y\n\n").empty());
  CHECK(with("TextureFile a b.png\nVCGLIB generated\nCreated on 3 May\nx\n") ==
        std::vector<std::string>{
            "header lines that begin with an unknown word, ignored: 4, the first with 'TextureFile'"});
  CHECK(with("Caf\xC3\xA9 noir\n").at(0).ends_with("the first with 'Caf\x3F\x3F'"));
}

TEST_CASE("ply: malformed headers are refused with their line") {
  const auto broken = [](const std::string& from, const std::string& to) {
    return refusal(replaced(kAsciiFile, from, to), "m.ply");
  };
  CHECK(contains(broken("ascii 1.0", "ascii 2.0"), "line 2 of 'a': PLY header: version '2.0'"));
  CHECK(contains(broken("ascii 1.0", "utf8 1.0"), "format 'utf8' is not known"));
  CHECK(contains(broken("format ascii 1.0\n", ""), "no format"));
  CHECK(contains(broken("vertex 4", "vertex -4"), "line 4 of 'a': PLY header: '-4' is not a count"));
  CHECK(contains(broken("vertex 4", "vertex"), "is not a count"));
  CHECK(contains(broken("vertex 4", "vertex 4e0"), "is not a count"));
  CHECK(contains(broken("property float x", "property real x"), "'real' is not a PLY type"));
  CHECK(contains(broken("property float x", "property float"), "without a name"));
  CHECK(contains(broken("property float x", "property float y"), "a second property 'y'"));
  for (const char* line :
       {"propety float x", "shape list uchar int x", "elemnt vertex 4", "Face face 3", "Format x", "0.5"}) {
    CHECK(contains(broken("property float x", line), "is not a header keyword"));
  }
  CHECK(contains(broken("property float x", "shape float x"), "'shape' is not a header keyword"));
  CHECK(contains(broken("list uchar int", "list float int"), "must be of an integer type"));
  CHECK(contains(broken("element face 2", "element vertex 2"), "a second element 'vertex'"));
  CHECK(contains(broken("element vertex 4\n", ""), "a property before any element"));
  CHECK(contains(broken("end_header\n", ""), "is not a header keyword"));
  CHECK(contains(broken("property float z\n", ""), "has no property 'z'"));
  CHECK(contains(broken("property float z\n", "property list uchar float z\n"), "is a list"));
  CHECK(contains(broken("list uchar int", "list uchar float"), "is not of an integer type"));
  CHECK(contains(broken("vertex_indices", "corners"), "no list 'vertex_indices'"));
  CHECK(code(header("ascii", kFaces), "m.ply") == ErrorCode::empty_mesh);
  CHECK(contains(refusal(header("ascii", kVertexElement + "element tristrips 1\nproperty int strip\n"), "m.ply"),
                 "element 'tristrips' has no list 'vertex_indices'"));
}

TEST_CASE("ply: malformed text is refused with its line") {
  const auto broken = [](const std::string& from, const std::string& to) {
    return refusal(replaced(kAsciiFile, from, to), "m.ply");
  };
  CHECK(contains(broken("0 0 1.5\n", "0 0\n"), "line 14 of 'a': the line ends before"));
  CHECK(contains(broken("0 0 1.5\n", "0 0 1,5\n"), "line 14 of 'a': '1,5' is not a number"));
  CHECK(contains(broken("3 0 1 2\n", "3 0 1 4\n"), "line 15 of 'a': index 4, but there are 4 vertices"));
  CHECK(contains(broken("3 0 1 2\n", "3 0 1 -1\n"), "line 15 of 'a': index -1"));
  CHECK(contains(broken("3 0 1 2\n", "3 0 1 1.0\n"), "'1.0' is not an integer"));
  CHECK(contains(broken("3 0 1 2\n", "-3 0 1 2\n"), "-3 is not a valid length"));
  CHECK(contains(broken("3 0 1 2\n", "0\n"), "line 15 of 'a': a face without corners"));
  CHECK(contains(broken("4 0 1 2 3\n", ""), "truncated"));
  CHECK(contains(broken("4 0 1 2 3\n", "4 0 1 2 3\n3 0 1 2\n"), "line 17 of 'a': left-over text"));
  CHECK(code(replaced(kAsciiFile, "0 0 1.5", "0 0 inf"), "m.ply") == ErrorCode::non_finite_vertex);
  CHECK(code(replaced(kAsciiFile, "0 0 1.5", "0 nan 1.5"), "m.ply") == ErrorCode::non_finite_vertex);
}

TEST_CASE("ply: malformed bytes are refused with their place") {
  const std::size_t body = kLittle.size() - 4 * 12 - 1 - 12 - 1 - 16;
  const auto patched = [&](std::size_t at, const std::string& bytes) {
    return std::string(kLittle).replace(body + at, bytes.size(), bytes);
  };
  CHECK(contains(refusal(patched(53, raw(std::int32_t{4})), "m.ply"), "index 4, but there are 4 vertices"));
  CHECK(contains(refusal(patched(53, raw(std::int32_t{-1})), "m.ply"), "index -1"));
  CHECK(contains(refusal(kLittle.substr(0, kLittle.size() - 1), "m.ply"),
                 "truncated: 4 bytes are needed here, 3 remain"));
  const std::string nan = patched(8, raw(std::numeric_limits<float>::quiet_NaN()));
  CHECK(code(nan, "m.ply") == ErrorCode::non_finite_vertex);
  CHECK(contains(refusal(nan, "m.ply"), "byte " + std::to_string(body + 8) + " of 'a'"));
  CHECK(contains(refusal(kLittle + "more", "m.ply"), "4 left-over bytes"));
  for (const char* count : {"3", "4294967295", "18446744073709551615", "99999999999999999999999"}) {
    CHECK(contains(refusal(replaced(kLittle, "face 2", "face " + std::string(count)), "m.ply"), "truncated"));
  }
}

TEST_CASE("ply: the limits of vertices and triangles hold") {
  ReadLimits limits;
  limits.max_vertices = 3;
  auto vertices = read(kAsciiFile, "m.ply", limits);
  REQUIRE(!vertices.ok());
  CHECK(vertices.error().code == ErrorCode::too_large);
  limits = {};
  limits.max_triangles = 2;
  for (const std::string& file : {kAsciiFile, kLittle}) {
    auto triangles = read(file, "m.ply", limits);
    REQUIRE(!triangles.ok());
    CHECK(triangles.error().code == ErrorCode::too_large);
  }
}

// Big-endian files are read value by value, little-endian ones many records at a time where they are plain.
TEST_CASE("ply: both byte orders give the same bits and the same refusals") {
  Dice dice(21);
  std::size_t good = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto [big, little] = any_ply(dice);
    const ReadLimits limits{100, dice.chance(0.1) ? 5U : 100U};
    const auto one = read(big, "m.ply", limits), many = read(little, "m.ply", limits);
    INFO("file " << i << ": " << (one ? "read" : one.error().message));
    REQUIRE(one.ok() == many.ok());
    if (!one) {
      const std::size_t more = little.size() - big.size();  // "little" is a longer word: places are so much later
      const std::string where = "byte ";
      const bool has_place = one.error().where.starts_with(where);
      CHECK(one.error().code == many.error().code);
      CHECK(many.error().where ==
            (has_place ? where + std::to_string(std::stoul(one.error().where.substr(where.size())) + more)
                       : one.error().where));
      const auto what = [](const Error& error) { return error.message.substr(error.message.find("'a'")); };
      CHECK(what(one.error()) == what(many.error()));
      continue;
    }
    ++good;
    CHECK(one->mesh.triangles == many->mesh.triangles);
    REQUIRE(one->mesh.positions.size() == many->mesh.positions.size());
    CHECK(std::memcmp(one->mesh.positions.data(), many->mesh.positions.data(),
                      one->mesh.positions.size() * sizeof(Vec3)) == 0);
    CHECK(one->notes.polygons == many->notes.polygons);
    CHECK(one->notes.skipped_primitives == many->notes.skipped_primitives);
  }
  CHECK(good > 500);
}

}  // namespace meshgauge::api::test
