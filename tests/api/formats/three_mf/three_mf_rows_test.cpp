#include "api/formats/three_mf/three_mf_rows.h"

#include <algorithm>
#include <random>

#include "tests/api/formats/three_mf_files.h"

namespace meshgauge::api::test {
namespace {

constexpr std::size_t kNoLimit = 1000;
const std::string kCoreNamespace = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
constexpr std::size_t kPieceBytes = 65'536;  // the reader gets a model in pieces of this size

struct TakenVertices {
  std::vector<Vec3> positions;
  XmlTaken taken;
};

TakenVertices taken_vertices(std::string_view text, std::size_t most = kNoLimit) {
  TakenVertices out;
  out.taken = take_mf_vertices(text, most, out.positions);
  return out;
}

struct TakenTriangles {
  std::vector<Triangle> triangles;
  XmlTaken taken;
};

TakenTriangles taken_triangles(std::string_view text, std::size_t vertices = 10) {
  TakenTriangles out;
  out.taken = take_mf_triangles(text, kNoLimit, vertices, out.triangles);
  return out;
}

// Replaces the first `from`, which must be there.
std::string with_replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t place = text.find(from);
  REQUIRE(place != std::string::npos);
  return text.replace(place, from.size(), to);
}

// All of the answer in one text.
std::string mesh_or_refusal(const std::string& document) {
  const auto result = read(package(document), "m.3mf");
  if (!result) return result.error().message;
  std::string text;
  for (const Vec3& p : result->mesh.positions) text += raw(p.x()) + raw(p.y()) + raw(p.z());
  for (const Triangle& triangle : result->mesh.triangles) text += raw(triangle);
  for (const std::string& remark : result->notes.remarks) text += remark;
  return text;
}

// expat alone reads UTF-16.
std::string as_utf16(const std::string& ascii) {
  std::string wide = "\xFF\xFE";
  for (const char c : with_replaced(ascii, " encoding=\"UTF-8\"", "")) wide += {c, '\0'};
  return wide;
}

std::string by_expat(const std::string& ascii) { return mesh_or_refusal(as_utf16(ascii)); }

std::string with_mesh(const std::string& mesh) {
  return model("<object id=\"1\"><mesh>" + mesh + "</mesh></object>", kItem, "xmlns:q=\"u\"");
}

// Meshes in the ways in which programs write them, and in some in which they do not.
const std::string kMeshes[] = {
    "<vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\".5\" z=\"-3e-2\"/><vertex x=\"0\" y=\"1\" "
    "z=\"7\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"2\" v2=\"1\" v3=\"0\" "
    "pid=\"1\" p1=\"0\" p2=\"0\" p3=\"0\"/></triangles>",
    "\r\n <vertices>\r\n  <vertex x='0' y='0' z='0' />\r\n  <vertex y='1' x='2' z='3' />\r\n\t<vertex x='4'\r\n y='5' "
    "z='6'/>\r\n </vertices>\r\n <triangles>\r\n  <triangle v3='0' v1='1' paint_color='4&lt;' v2='2' />\r\n"
    "<triangle v1='0' v2='1' v3='2' paint_color='>' p1=''/>\r\n </triangles>\r\n",
    "<vertices>\n<vertex x=\"0\" y=\" 0\" z=\"0\"/><!-- > --><vertex x=\"1\" y=\"&#50;\" z=\"0\"/>\n\n<q:row/>"
    "<vertex x=\"3\" y=\"1\" z=\"1\" more=\"\"></vertex>\n<![CDATA[><vertex x=\"9\" y=\"9\" z=\"9\"/>]]>\n"
    "<vertex x=\"4\" y=\"1\" z=\"+1\"/></vertices><vertices/><vertices><vertex x=\"5\" y=\"5\" z=\"5\"/></vertices>"
    "<triangles>\r<triangle v1=\"0\" v2=\"1\" v3=\"-0\" q:x=\"1\"/>text >\r<triangle v1=\"0\" v2=\"1\" "
    "v3=\"04\"/></triangles>",
    "<vertices>\n<vertex x=\"0\" y=\"0\" z=\"0\"/>\n<vertex x=\"1\" y=\"1\" z=\"1\"/>\r\n</vertices>\n<triangles>\n"
    "<triangle v1=\"0\" v2=\"1\" v3=\"1\"/>\n<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>\n</triangles>",
    "<m:vertices xmlns='v' xmlns:m='" + kCoreNamespace +
        "'><vertex x='1' y='1' z='1'/><vertex x='2' y='2' z='2'/></m:vertices>" + "<triangles xmlns='" +
        kCoreNamespace + "'></triangles>"};

// Separated by '|'.
constexpr std::string_view kRowTokens =
    "<|>|/|=|\"|'|&| "
    "|\n|\r|\r\n|\t|\v|0|-|+|.|e|x|v1|V1|nan|inf|1e999|1e-999|99999999999|0x1|<!--|-->|<![CDATA[|]]>|<?a|?>"
    "|&lt;|&b;|<q:a/>|<p:a/>|<a/>| q:x='1'| p1='1'| xmlns=''| v1='0'|<vertex "
    "|</vertex>|<vertices>|<vertices/>|</vertices>"
    "|<triangles>|</triangles>|<vertex x='1' y='1' z='1'/>|<triangle v1='0' v2='0' v3='0'/>";

std::vector<std::string> tokens() {
  std::vector<std::string> all;
  for (std::string_view rest = kRowTokens; !rest.empty();) {
    all.emplace_back(rest.substr(0, rest.find('|')));
    rest.remove_prefix(std::min(rest.size(), all.back().size() + 1));
  }
  return all;
}

std::string mutated(std::string text, std::mt19937& random) {
  static const std::vector<std::string> kAll = tokens();
  const auto below = [&](std::size_t count) { return random() % count; };
  for (std::size_t changes = 1 + below(3); changes > 0; --changes) {
    const std::size_t place = below(text.size());
    const std::string& token = kAll[below(kAll.size())];
    const std::size_t kind = below(4);
    if (kind == 0) text.insert(place, token);
    if (kind == 1) text.replace(place, token.size(), token);
    if (kind == 2) text.erase(place, 1 + below(8));
    if (kind == 3) text.insert(below(text.size()), text.substr(place, below(60)));
  }
  return text;
}

}  // namespace

TEST_CASE("3mf: rows: vertices of the common form are taken with their lines") {
  const std::string rows = "<vertex x=\"1\" y=\"-2.5e3\" z=\".5\"/>\r\n\t<vertex\nz='3' x='+1' y='2' />";
  const TakenVertices all = taken_vertices(rows);
  CHECK(all.positions == std::vector<Vec3>{{1, -2500, 0.5}, {1, 2, 3}});
  CHECK(all.taken.bytes == rows.size());
  CHECK(all.taken.lines == 2);
  const TakenVertices one = taken_vertices(rows, 1);
  CHECK(one.positions.size() == 1);
  CHECK(one.taken.bytes == rows.find('\r'));
  CHECK(one.taken.lines == 0);
  CHECK(taken_vertices(rows + " \n</vertices>").taken.bytes == rows.size());
  CHECK(taken_vertices("").taken.bytes == 0);
}

TEST_CASE("3mf: rows: triangles of the common form are taken") {
  const std::string rows =
      "<triangle v1=\"0\" v2=\"9\" v3=\"5\"/>\n<triangle p1='0' v3='1' v2='2' pid='&quot;'/><triangle v1='1'/>";
  const TakenTriangles one = taken_triangles(rows);
  CHECK(one.triangles == std::vector<Triangle>{{0, 9, 5}});
  CHECK(one.taken.bytes == rows.find('\n'));
  CHECK(taken_triangles(rows, 9).triangles.empty());
  const std::string painted = "<triangle pid='1' p1='0' p2='>' v1='3' paint_color='4C' v2='2' paint_seam='' v3='1'/>";
  CHECK(taken_triangles(painted).triangles.empty());
  CHECK(taken_triangles(with_replaced(painted, "'>'", "'<'")).triangles.empty());
  CHECK(taken_triangles(with_replaced(painted, "'>'", "'&b;'")).triangles.empty());
  CHECK(taken_triangles(with_replaced(painted, "'>'", "'a b'")).triangles == std::vector<Triangle>{{3, 2, 1}});
}

TEST_CASE("3mf: rows: the first row of another form is left") {
  const std::string row = "<vertex x=\"1\" y=\"2\" z=\"3\"/>";
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"vertex", "vertexx"}, {"vertex", "q:vertex"}, {"x=", "w="},      {"x=", "y="},         {"x=", "x ="},
           {"x=", "q:x="},        {"x=\"1\"", ""},        {"\"1\"", "'1\""}, {"\"1\"", "\"\""},    {"\"1\"", "\" 1\""},
           {"\"1\"", "\"1 \""},   {"\"1\"", "\"inf\""},   {"1", "&#49;"},    {"1", "1e999"},       {"1", "0x1"},
           {"\" y", "\"y"},       {" y", "\vy"},          {"/>", "/ >"},     {"/>", "></vertex>"}, {"<", "<!---->"},
           {"<", "]]>"},          {"3\"", "3\" a='1'"}}) {
    CAPTURE(to);
    const TakenVertices first = taken_vertices(row + with_replaced(row, from, to));
    CHECK(first.positions == std::vector<Vec3>{{1, 2, 3}});
    CHECK(first.taken.bytes == row.size());
  }
}

TEST_CASE("3mf: rows: a text that ends anywhere is read no farther") {
  const std::string row = "<vertex x=\"1\" y=\"2\" z=\"3\"/>";
  const std::string rows = row + "<vertex x='1' y='2' z='>'/>\n<triangle v1='0' pid='>'>";
  for (std::size_t from = 0; from < rows.size(); ++from) {
    for (std::size_t end = from; end <= rows.size(); ++end) {
      if (end > from && rows[end - 1] != '>') continue;
      const std::vector<char> exact(rows.begin() + static_cast<std::ptrdiff_t>(from),
                                    rows.begin() + static_cast<std::ptrdiff_t>(end));
      const std::string_view text(exact.data(), exact.size());
      CHECK(taken_vertices(text).positions.size() == (from == 0 && end >= row.size() ? 1 : 0));
      CHECK(taken_triangles(text).triangles.empty());
    }
  }
}

TEST_CASE("3mf: rows: the same answer as by expat, however a mesh is written") {
  CHECK(mesh_or_refusal(with_mesh(kMeshes[0])).size() == 9 * sizeof(double) + 2 * sizeof(Triangle));
  CHECK(contains(mesh_or_refusal(with_mesh(kMeshes[3])), "line 10 of 'a': index '2', but there are 2 vertices"));
  std::mt19937 random(7);
  for (const std::string& mesh : kMeshes) {
    CAPTURE(mesh);
    CHECK(mesh_or_refusal(with_mesh(mesh)) == by_expat(with_mesh(mesh)));
    for (int i = 0; i < 1000; ++i) {
      const std::string document = with_mesh(mutated(mesh, random));
      CAPTURE(document);
      REQUIRE(mesh_or_refusal(document) == by_expat(document));
    }
  }
}

TEST_CASE("3mf: rows: the same answer wherever the piece ends") {
  for (const std::string& mesh : kMeshes) {
    const std::string document = with_mesh(mesh);
    const std::string expected = by_expat(document);
    const std::size_t place = document.find("<resources>");
    for (std::size_t cut = place; cut < document.size(); ++cut) {
      std::string padded = document;
      padded.insert(place, kPieceBytes - cut, ' ');
      CAPTURE(document.substr(0, cut));
      REQUIRE(mesh_or_refusal(padded) == expected);
    }
  }
}

TEST_CASE("3mf: rows: other encodings and namespaces, and limits, hold as by expat") {
  const std::string document = with_mesh(kMeshes[0]);
  const std::string expected = mesh_or_refusal(document);
  CHECK(mesh_or_refusal("\xEF\xBB\xBF" + document) == expected);
  CHECK(mesh_or_refusal(with_replaced(document, "UTF-8", "ISO-8859-1")) == expected);
  CHECK(contains(mesh_or_refusal(with_replaced(document, "UTF-8", "EBCDIC")), "unknown encoding"));
  ReadLimits few;
  few.max_vertices = 2;
  CHECK(contains(read(package(document), "m.3mf", few).error().message, "more vertices than the limit of 2"));
  few = ReadLimits{};
  few.max_triangles = 1;
  CHECK(contains(read(package(document), "m.3mf", few).error().message, "more triangles than the limit of 1"));
}

TEST_CASE("3mf: rows: characters of UTF-16 whose bytes look like a row are text") {
  const std::string document = with_replaced(with_mesh(kMeshes[0]), " encoding=\"UTF-8\"", "");
  std::string wide("\xFE\xFF", 2);
  const auto widened = [](const std::string& ascii) {
    std::string text;
    for (const char c : ascii) text += {'\0', c};
    return text;
  };
  wide += widened(document);
  // The piece ends in the first row, and the second one begins with the end of its tag.
  const std::size_t row = wide.find(widened("<vertex "));
  const std::string hidden = "<vertex  x=\"1\" y=\"2\" z=\"3\"/>";
  REQUIRE(hidden.size() % 2 == 0);
  wide.insert(wide.find(widened("/>"), row) + widened("/>").size(), hidden);
  wide.insert(wide.find(widened("<resources>")), widened(std::string((kPieceBytes - row) / 2 - 1, ' ')));
  CHECK(mesh_or_refusal(wide) == mesh_or_refusal(document));
}

// expat rescans a comment from its beginning whenever it gets more of it.
TEST_CASE("3mf: rows: ends of tags in a comment take linear time") {
  const std::string comment = "<!--" + std::string(1'000'000, '>') + "-->";
  const std::string tags = [] {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += "<vertices>";
    return "<!--" + text + "-->";
  }();
  const std::string document = with_mesh(with_replaced(kMeshes[0], "<vertices>", "<vertices>" + comment + tags));
  CHECK(mesh_or_refusal(document) == mesh_or_refusal(with_mesh(kMeshes[0])));
}

}  // namespace meshgauge::api::test
