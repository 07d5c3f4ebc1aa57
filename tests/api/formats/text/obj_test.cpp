#include "api/formats/file/readers.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

const std::string kUnitCorners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

Mesh mesh_of_obj(const std::string& text) {
  auto result = read(text, "m.obj");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(result->mesh);
}

Vec3 first_vertex(const std::string& numbers) {
  return mesh_of_obj("v " + numbers + "\n" + kUnitCorners + "f 1 2 3\n").positions.at(0);
}

std::string refused_vertex(const std::string& numbers) {
  return refusal(kUnitCorners + "v " + numbers + "\nf 1 2 3\n", "m.obj");
}

// Every statement of the specification that is no surface by itself.
const std::string kAttributes =
    "vp 0 1\ncstype rat bspline\ndeg 3 3\nbmat u 1 0 0 1\nstep 1 1\nparm u 0 1\ntrim 0 1 1\nhole 0 1 1\nscrv 0 1 1\n"
    "sp 1\nend\ncon 1 0 1 1 2 0 1 1\nmg off\nbevel off\nd_interp off\nmaplib m\nusemap m\ntrace_obj t\nctech cparm 1\n"
    "stech cparma 1 1\nres 1 1\n";

ReadNotes notes_of(const std::string& text) {
  auto result = read(text, "m.obj");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(result->notes);
}

std::string unread_remark(const std::string& kind, int count) {
  return "not read and not measured, though part of the surface: " + kind + ": " + std::to_string(count);
}

void check_same(const Mesh& a, const Mesh& b) {
  CHECK(a.positions == b.positions);
  CHECK(a.triangles == b.triangles);
}

// Decimal numbers of every length and exponent, as exporters and as attackers write them.
class Decimals {
 public:
  std::string next() {
    switch (pick(6)) {
      case 0:
        return printed("%.6f", uniform(-1000, 1000));
      case 1:
        return printed("%.17g", any_double());
      case 2:
        return printed("%.9g", static_cast<double>(static_cast<float>(uniform(-1, 1))));
      case 3:
        return sign() + digits(1 + pick(5)) + "." + digits(1 + pick(40)) + "e" + std::to_string(pick(600) - 300);
      case 4:
        return sign() + "." + digits(1 + pick(25));
      default:
        return sign() + digits(1 + pick(30)) + (pick(2) == 0 ? "." : "");
    }
  }

 private:
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double any_double() {
    for (;;) {
      const auto value = std::bit_cast<double>(std::uniform_int_distribution<std::uint64_t>()(random_));
      if (std::abs(value) <= kMaxCoordinate) return value;
    }
  }
  std::string sign() { return std::array<std::string, 3>{"", "-", "+"}[static_cast<std::size_t>(pick(3))]; }
  std::string digits(int count) {
    std::string out;
    for (; count > 0; --count) out += static_cast<char>('0' + pick(10));
    return out;
  }
  static std::string printed(const char* format, double value) {
    char text[400];
    std::snprintf(text, sizeof text, format, value);
    return text;
  }

  std::mt19937_64 random_{7};
};

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

}  // namespace

TEST_CASE("obj: every way to write a face gives the same triangle") {
  const Mesh plain = mesh_of_obj(kUnitCorners + "f 1 2 3\n");
  CHECK(plain.positions.size() == 4);
  CHECK(plain.triangles == std::vector<Triangle>{{0, 1, 2}});
  for (const char* face :
       {"f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/1/1 2/2/2 3/3/3", "f 1/7/-9 2// 3/", "f -4 -3 -2", "f\t1  2 \t3 ",
        "f 1 \\\n 2 \\\r\n 3", "f 1 2 3 # the first", "fo 1 2 3", "  f 1 2 3", "f 000001 2 3"}) {
    CAPTURE(std::string(face));
    check_same(mesh_of_obj(kUnitCorners + face + "\n"), plain);
    check_same(mesh_of_obj(kUnitCorners + face), plain);
  }
}

TEST_CASE("obj: line ends, byte order mark and continuation lines") {
  const Mesh plain = mesh_of_obj(kUnitCorners + "f 1 2 3\nf 1 2 4\n");
  std::string text = kUnitCorners + "f 1 2 3\nf 1 2 4";
  for (const char* line_end : {"\n", "\r\n", "\r", "\n\n", "\r\n \t\r\n"}) {
    std::string other;
    for (const char c : text) other += c == '\n' ? std::string(line_end) : std::string(1, c);
    check_same(mesh_of_obj(other), plain);
    check_same(mesh_of_obj("\xEF\xBB\xBF" + other + line_end), plain);
  }
  check_same(mesh_of_obj("v 0 \\\n0 0\nv 1 0\\\n 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1\\\n 2 4\\\n"), plain);
}

TEST_CASE("obj: statements other than faces and vertices are ignored") {
  const Mesh plain = mesh_of_obj(kUnitCorners + "f 1 2 3\n");
  check_same(mesh_of_obj("# f 1 2 3 \\\n" + kUnitCorners +
                         "mtllib ../../etc/passwd\ng a f 1 2 3\no f\nusemtl \\\nx 9 9 9\nvn 0 0 1\nvt nan\ns off\n"
                         "USEMTL a\nlod 3\nbevel on\nc_interp on\nmg 1 2\nshadow_obj x\nf 1 2 3\n#"),
             plain);
  const auto result = read(kUnitCorners + kAttributes + "f 1 2 3\n", "m.obj");
  REQUIRE(result.ok());
  CHECK(result->notes.remarks.empty());
  CHECK(result->notes.skipped_primitives == 0);
}

TEST_CASE("obj: polygons become triangles, lines and points are counted") {
  const auto result = read(kUnitCorners + "v 1 1 1\nf 1 2 3 4 5\nl 1 2\np 1\nf 1 2\nf 3 4 5\nf 1 1 2\n", "m.obj");
  REQUIRE(result.ok());
  CHECK(result->mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {2, 3, 4}, {0, 0, 1}});
  CHECK(result->notes.polygons.count == 1);
  CHECK(result->notes.skipped_primitives == 3);
  CHECK(result->format == Format::obj);
}

TEST_CASE("obj: weights and colours do not move a vertex") {
  const Vec3 expected(1, 2, 3);
  for (const char* extras : {"", " 1", " .5 .5 .5", " 1 .5 .5 1e0", " 0.1 # colour"}) {
    CHECK(first_vertex("1 2 3" + std::string(extras)) == expected);
  }
  CHECK(contains(refused_vertex("1 2 3 4 5 6 7 8"), "more than seven"));
  CHECK(contains(refused_vertex("1 2 3 red"), "'red' is not a number"));
}

TEST_CASE("obj: numbers are bit-equal to strtod") {
  Decimals decimals;
  std::string text;
  std::vector<std::string> numbers;
  for (int i = 0; i < 30'000; ++i) {
    numbers.push_back(decimals.next());
    text += (i % 3 == 0 ? "\nv " : " ") + numbers.back();
  }
  for (const char* edge : {"1e-400", "-1e-400", "4.9e-324", "2.2250738585072011e-308", "1e-320", "2e-324", "+0", "-0",
                           "9007199254740993", "0.1", "1.7976931348623157e307"}) {
    numbers.insert(numbers.end(), 3, edge);
    text += std::string("\nv ") + edge + " " + edge + " " + edge;
  }
  const Mesh mesh = mesh_of_obj(text + "\nf 1 2 3\n");
  std::size_t different = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double expected = std::strtod(numbers[i].c_str(), nullptr);
    different += !same_bits(mesh.positions[i / 3][static_cast<int>(i % 3)], expected);
  }
  CHECK(different == 0);
}

TEST_CASE("obj: bad numbers are refused with their line") {
  for (const char* bad : {"1,5 2 3", "1.0.0 2 3", "1 2-3 4", "1 2 4e", "1 2 0x10", "1 2 --3", "1 2 +-3", "1 2 ++3",
                          "1 2 e5", "1 2 .", "1 2 3.1+e2", "a b c", "1 2 3f", "1 2 3\\4"}) {
    CAPTURE(std::string(bad));
    const std::string message = refused_vertex(bad);
    CHECK(contains(message, "line 5 of 'a'"));
    CHECK(contains(message, "is not a number"));
  }
  CHECK(contains(refused_vertex("1 2"), "three coordinates"));
  CHECK(contains(refused_vertex(""), "three coordinates"));
}

TEST_CASE("obj: coordinates that are not finite are refused, used or not") {
  for (const char* bad : {"nan 0 0", "0 inf 0", "0 0 -inf", "0 0 1e999", "-1e400 0 0", "0 0 NAN", "0 infinity 0"}) {
    CAPTURE(std::string(bad));
    const std::string text = kUnitCorners + "v " + bad + "\nf 1 2 3\n";
    CHECK(code(text, "m.obj") == ErrorCode::non_finite_vertex);
    CHECK(contains(refusal(text, "m.obj"), "line 5 of 'a'"));
  }
  CHECK(code("v 1e308 0 0\n" + kUnitCorners + "f 1 2 3\n", "m.obj") == ErrorCode::coordinate_too_large);
}

TEST_CASE("obj: bad indices are refused with their line") {
  for (const char* bad : {"f 1 2 5", "f 1 2 0", "f 1 2 -5", "f 1 2 99999999999999999999", "f 1 2 4294967297",
                          "f -9223372036854775808 1 2", "f 5// 1 2"}) {
    CAPTURE(std::string(bad));
    CHECK(code(kUnitCorners + bad, "m.obj") == ErrorCode::index_out_of_range);
    CHECK(contains(refusal(kUnitCorners + bad + "\nf 1 2 3", "m.obj"), "line 5 of 'a'"));
  }
  for (const char* bad :
       {"f 1.0 2 3", "f a b c", "f 1/2/3/4 2 3", "f 1 2 3x", "f 1|2|3", "f 1 2 /3", "f", "f 1 2 +3"}) {
    CAPTURE(std::string(bad));
    CHECK(code(kUnitCorners + bad, "m.obj") == ErrorCode::unreadable_mesh);
    CHECK(contains(refusal(kUnitCorners + bad + "\nf 1 2 3", "m.obj"), "line 5 of 'a'"));
  }
}

TEST_CASE("obj: faces may precede their vertices, negative indices count from their own line") {
  CHECK(mesh_of_obj("f 1 2 3\nf 2 3 4\n" + kUnitCorners).triangles == std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}});
  CHECK(contains(refusal("f 1 2 3\nf 2 3 5\n" + kUnitCorners, "m.obj"), "line 2 of 'a'"));
  CHECK(contains(refusal("f -1 2 3\n" + kUnitCorners, "m.obj"), "line 1 of 'a'"));
}

TEST_CASE("obj: the rest of a broken line is refused") {
  CHECK(contains(refusal(kUnitCorners + "1 2 3\nf 1 2 3\n", "m.obj"), "line 5 of 'a': '1' does not begin"));
  CHECK(
      contains(refusal(kUnitCorners + std::string("\0\0\n", 3) + "f 1 2 3\n", "m.obj"), "line 5 of 'a': binary data"));
  CHECK(
      contains(refusal(kUnitCorners + std::string("g \0\n", 4) + "f 1 2 3\n", "m.obj"), "line 5 of 'a': binary data"));
}

TEST_CASE("obj: the limits of vertices and triangles hold") {
  ReadLimits limits;
  limits.max_vertices = 4;
  limits.max_triangles = 2;
  CHECK(read(kUnitCorners + "f 1 2 3 4", "m.obj", limits).ok());
  auto faces = read(kUnitCorners + "f 1 2 3 4\nf 1 2 3", "m.obj", limits);
  REQUIRE(!faces.ok());
  CHECK(faces.error().code == ErrorCode::too_large);
  auto vertices = read(kUnitCorners + "v 1 1 1\nf 1 2 3", "m.obj", limits);
  REQUIRE(!vertices.ok());
  CHECK(vertices.error().code == ErrorCode::too_large);
}

TEST_CASE("obj: long lines and long numbers take linear time") {
  std::string text = kUnitCorners + "f";
  for (int i = 0; i < 300'000; ++i) text += i % 2 == 0 ? " 1" : " 2";
  CHECK(mesh_of_obj(text).triangles.size() == 299'998);
  CHECK(first_vertex("0." + std::string(1'000'000, '0') + "1 1 2").x() == 0);
  CHECK(first_vertex(std::string(100'000, '0') + "1.5 1 2").x() == 1.5);
}

TEST_CASE("obj: lines that begin with a dollar are comments") {
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const std::string& file : {"$ made by a test\n" + mesh, "# c\n$\n" + mesh + "$f 1 2 3", mesh + " $ v 1 2 3\n"}) {
    const auto result = read(file, "");
    REQUIRE(result.ok());
    CHECK(result->format == Format::obj);
    CHECK(result->mesh.triangles.size() == 1);
    CHECK(result->mesh.positions.size() == 3);
  }
}

TEST_CASE("obj: a vertex of two coordinates is refused with its line") {
  CHECK(refusal("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", "m.obj") == "line 2 of 'a': a vertex needs three coordinates");
}

TEST_CASE("obj: free-form surfaces, patches and included files are noted beside faces, and refused alone") {
  const std::string surface = "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend\n";
  for (const auto& [statement, kind] : {std::pair<std::string, std::string>{surface, "free-form surfaces (surf)"},
                                        {"surf\\\n 0 1 0 1 1 2 3 4\n", "free-form surfaces (surf)"},
                                        {"bzp 1 2 3 4\n", "Bezier patches (bzp)"},
                                        {"bsp 1 2 3 4\n", "B-spline patches (bsp)"},
                                        {"cdp 1 2 3 4\n", "Cardinal patches (cdp)"},
                                        {"call part.obj\n", "included files (call)"},
                                        {"csh -cat part.obj\n", "commands (csh)"},
                                        {"face 1 2 3\n", "unknown statements (face)"},
                                        {"g1\n", "unknown statements (g1)"}}) {
    CAPTURE(statement);
    const auto noted = read(kUnitCorners + statement + "f 1 2 3\n" + statement, "m.obj");
    REQUIRE(noted.ok());
    CHECK(noted->notes.remarks == std::vector<std::string>{unread_remark(kind, 2)});
    CHECK(noted->mesh.triangles.size() == 1);
    CHECK(code(kUnitCorners + statement, "m.obj") == ErrorCode::unsupported_format);
    CHECK(refusal(kUnitCorners + statement, "m.obj") ==
          "'a' has no triangles, only what is not read (" + kind + ": 1): export it as triangles");
  }
}

TEST_CASE("obj: any number of unknown statements is counted, in linear time") {
  std::string text = kUnitCorners + "f 1 2 3\n";
  for (int i = 0; i < 200'000; ++i) text += "word_" + std::to_string(i % 1000) + " 1\n";
  const ReadNotes notes = notes_of(text);
  REQUIRE(notes.remarks.size() == Unread::kMostKinds);
  CHECK(notes.remarks.front() == unread_remark("unknown statements (word_0)", 200));
  CHECK(notes.remarks.back() == unread_remark("all other kinds", 993 * 200));
}

TEST_CASE("obj: curves are counted as lines") {
  for (const char* curve : {"curv 0 1 1 2 3\n", "curv2 1 2\n", "cdc 1 2 3 4\n", "l 1 2\n", "l\\\n 1 2\n", "p 1\n"}) {
    CAPTURE(std::string(curve));
    CHECK(notes_of(kUnitCorners + "f 1 2 3\n" + curve).skipped_primitives == 1);
    CHECK(refusal(kUnitCorners + curve, "m.obj") == "'a' has no triangles");
  }
}

TEST_CASE("obj: statements in capitals or joined to their numbers are refused with their line and the remedy") {
  for (const auto& [line, seen, meant] : {std::array<std::string, 3>{"F 1 2 3", "F", "f"},
                                          {"V 1 2 3", "V", "v"},
                                          {"VN 0 0 1", "VN", "vn"},
                                          {"Vt 0 1", "Vt", "vt"},
                                          {"FO 1 2 3", "FO", "fo"},
                                          {"G part", "G", "g"},
                                          {"O part", "O", "o"},
                                          {"f1 2 3", "f1", "f"},
                                          {"f-3 -2 -1", "f-3", "f"},
                                          {"F1/1 2 3", "F1/1", "f"},
                                          {"v1.5 2 3", "v1.5", "v"},
                                          {"v,1,2,3", "v,1,2,3", "v"},
                                          {"f(1 2 3)", "f(1", "f"},
                                          {"fo1 2 3", "fo1", "fo"},
                                          {"vn0 0 1", "vn0", "vn"},
                                          {"l1 2", "l1", "l"},
                                          {"Curv2 1 2", "Curv2", "curv2"},
                                          {"Call x", "Call", "call"},
                                          {"F\\\n 1 2 3", "F", "f"}}) {
    CAPTURE(line);
    for (const std::string& more : {std::string(), std::string("f 1 2 3\n")}) {
      CHECK(refusal(kUnitCorners + line + "\n" + more, "m.obj") ==
            "line 5 of 'a': '" + seen + "' does not begin an OBJ statement; write '" + meant +
                "', in lower case and with a blank behind it");
    }
  }
  check_same(mesh_of_obj(kUnitCorners + "fo\\\n 1 2 3\n"), mesh_of_obj(kUnitCorners + "f 1 2 3\n"));
}

TEST_CASE("obj: a name or a path that ends in a backslash joins no statement of the surface, a comment no line") {
  for (const std::string line : {"usemtl C:\\m\\", "mtllib C:\\m\\", "o a\\", "g C:\\p\\", "vn 0 0 1 \\"}) {
    const std::string file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + line + "\nf 3 2 1\n";
    INFO(line);
    CHECK(refusal(file, "m.obj") ==
          "line 6 of 'a': '\\' at the end of the line before joins the statement 'f' to that "
          "line; remove the '\\'");
    CHECK(read("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + line + "\n1\nf 3 2 1\n", "m.obj").ok());
  }
  for (const std::string line : {"usemtl m # c:\\x\\", "s 1 # \\", "g a # \\"}) {
    const auto result = read("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + line + "\nf 1 2 3\n", "m.obj");
    REQUIRE(result.ok());
    CHECK(result->mesh.triangles.size() == 1);
  }
  CHECK(read("v 0 0 0\nv 1 0 0\nv 0 1 0\nnewmtl a\nKd 1 0 0\nmap_Kd a.png\nf 1 2 3\n", "m.obj")->notes.remarks.empty());
}

TEST_CASE("obj: NUL and 0x1A bytes after the last line are noted") {
  using namespace std::string_literals;
  const std::string text = kUnitCorners + "f 1 2 3\n";
  for (const std::string& end : {"\0"s, "\n\0\n"s, "\x1A"s, "\0\0\x1A\r\n \0"s}) {
    const auto result = read(text + end, "m.obj");
    REQUIRE(result.ok());
    check_same(result->mesh, mesh_of_obj(text));
    CHECK(result->notes.remarks == std::vector<std::string>{"NUL or 0x1A bytes after the last line, ignored"});
    CHECK(contains(refusal(text + end + "f 1 2 4\n", "m.obj"), ": binary data in a text file"));
  }
  CHECK(notes_of(text).remarks.empty());
  CHECK(contains(refusal(std::string(100, '\0'), "m.obj"), "holds binary data, not obj"));
}

}  // namespace meshgauge::api::test
