// The readers of OBJ and STL compared with tinyobjloader and libadmesh. Where both define the same thing they must read
// the same; where the others are known to differ, the reason is named (tinyobj_peer.cpp, admesh_peer.cpp).
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "tests/api/formats/admesh_peer.h"
#include "tests/api/formats/files.h"
#include "tests/api/formats/small_files.h"
#include "tests/api/formats/tinyobj_peer.h"
#include "tests/fuzz/dice.h"

namespace meshgauge::api::test {
namespace {

using fuzz::Dice;

template <class... Numbers>
std::string printed(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

// --- OBJ ------------------------------------------------------------------------------------------------------------

// A power of ten costs tinyobjloader two roundings more.
std::uint64_t most_steps(std::string_view text) {
  for (std::size_t i = 1; i + 1 < text.size(); ++i) {
    if ((text[i] == 'e' || text[i] == 'E') && std::isdigit(static_cast<unsigned char>(text[i - 1])) != 0) return 6;
  }
  return 4;
}

void check_against_tinyobj(const std::string& text, const Mesh& ours) {
  const Mesh theirs = by_tinyobj(text, ours.positions);
  const bool cloud = theirs.triangles.empty() && is_cloud(ours);
  CHECK((cloud || ours.triangles == theirs.triangles));
  REQUIRE(ours.positions.size() == theirs.positions.size());
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < ours.positions.size(); ++i) {
    for (int k = 0; k < 3; ++k) most = std::max(most, steps_apart(ours.positions[i][k], theirs.positions[i][k]));
  }
  CHECK(most <= most_steps(text));
}

std::string any_vertex(Dice& dice, bool exponents) {
  const double size = exponents ? dice.power(-8, 8) : dice.power(0, 5);
  const double x = dice.uniform(-size, size), y = dice.uniform(-size, size), z = dice.uniform(-size, size);
  const char* const formats[] = {"v %.6f %.6f %.6f", "v %.17g %.17g %.17g", "v  %.9g\t%.9g %.9g ", "v %g %+g %.0f 1",
                                 "v %.6e %.16E %.3f 0.5 0.25 1"};
  return printed(exponents          ? dice.pick(formats)
                 : dice.chance(0.5) ? "v %.6f %.9f %.12f"
                                    : "v %.15f %.3f %.0f",
                 x, y, z);
}

std::string any_corner(Dice& dice, int vertices) {
  const int index = dice.chance(0.5) ? dice.between(1, vertices) : -dice.between(1, vertices);
  const char* const forms[] = {"", "/7", "//3", "/2/5", "/-1/-1"};
  return std::to_string(index) + dice.pick(forms);
}

// Vertices and faces in turns, so that negative indices count from different places.
std::string any_obj(Dice& dice) {
  const std::string line_end = dice.chance(0.3) ? "\r\n" : "\n";
  const bool exponents = dice.chance(0.5);
  std::string text = "# made by a test" + line_end + "mtllib none.mtl" + line_end;
  int vertices = 0;
  for (int block = dice.between(1, 5); block > 0; --block) {
    for (int i = dice.between(1, 20); i > 0; --i, ++vertices) text += any_vertex(dice, exponents) + line_end;
    text += dice.chance(0.5) ? "g part of it" + line_end : "vn 0 0 1" + line_end + "usemtl red" + line_end;
    for (int i = dice.between(0, 20); i > 0; --i) {
      text += dice.chance(0.1) ? "  f" : "f";
      for (int corner = dice.between(2, 6); corner > 0; --corner) text += ' ' + any_corner(dice, vertices);
      text += line_end;
    }
  }
  return text + "f 1 1 1";
}

// --- STL ------------------------------------------------------------------------------------------------------------

float any_float(Dice& dice) {
  const float edges[] = {0.F,
                         -0.F,
                         1.F,
                         std::numeric_limits<float>::max(),
                         std::numeric_limits<float>::denorm_min(),
                         -std::numeric_limits<float>::min()};
  if (dice.chance(0.2)) return dice.pick(edges);
  return static_cast<float>(dice.sign() * dice.power(-30, 30));
}

std::vector<Facet> any_facets(Dice& dice) {
  std::vector<Facet> facets(static_cast<std::size_t>(dice.between(4, 40)));
  for (Facet& facet : facets) std::ranges::generate(facet, [&] { return any_float(dice); });
  return facets;
}

std::string binary_stl(const std::vector<Facet>& facets) {
  std::string out = std::string(80, 's') + raw(static_cast<std::uint32_t>(facets.size()));
  for (const Facet& facet : facets) {
    for (const float n : {-1.F, 0.F, 0.F}) out += raw(n);
    for (const float c : facet) out += raw(c);
    out += std::string(2, '\0');
  }
  return out;
}

std::string ascii_stl(const std::vector<Facet>& facets, const char* vertex_format) {
  std::string out = "solid made by a test\n";
  for (const Facet& f : facets) {
    out += "  facet normal -1 0 0\n    outer loop\n";
    for (std::size_t k = 0; k < 9; k += 3) {
      out += printed(vertex_format, static_cast<double>(f[k]), static_cast<double>(f[k + 1]),
                     static_cast<double>(f[k + 2]));
    }
    out += "    endloop\n  endfacet\n";
  }
  return out + "endsolid made by a test\n";
}

bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

// Compares with libadmesh's floats: the same for a binary file; for text, rounded once more, so perhaps the next float.
void check_against_admesh(const std::string& file, const Mesh& ours) {
  const auto theirs = by_admesh(file);
  REQUIRE(theirs.has_value());
  REQUIRE(ours.triangles.size() == theirs->size());
  const bool binary = file.size() == 84 + 50 * theirs->size();
  std::size_t different = 0;
  for (std::size_t i = 0; i < 9 * theirs->size(); ++i) {
    const float their = (*theirs)[i / 9][i % 9];
    const auto our = static_cast<float>(ours.positions[i / 3][static_cast<int>(i % 3)]);
    different += !same_bits(our, their) && (binary || std::nextafter(our, their) != their);
  }
  CHECK(different == 0);
}

// --- the corpus -----------------------------------------------------------------------------------------------------

// Calls compare(content, mesh) for each file of a suffix that is read; compare() gives the excuse, or nothing.
template <class Compare>
void compare_corpus(const std::string& suffix, Compare compare) {
  const auto root = corpus();
  if (!root) return;
  std::map<std::string, int> excuses;
  for (const char* folder : {"formats", "formats/real", "malformed", "malformed/real", "meshes", "adversarial"}) {
    for (const auto& entry : std::filesystem::directory_iterator(*root / folder)) {
      if (entry.path().extension() != suffix || entry.file_size() > 4'000'000) continue;
      CAPTURE(entry.path().string());
      const std::string content = file_content(entry.path());
      const auto result = read(content, entry.path().filename().string());
      if (!result || result->notes.gzip || "." + std::string(to_string(result->format)) != suffix) continue;
      ++excuses[std::string(compare(content, result->mesh))];
    }
  }
  for (const auto& row : excuses) MESSAGE(row.second << " files: " << (row.first.empty() ? "compared" : row.first));
  CHECK(excuses[""] > 5);
}

}  // namespace

TEST_CASE(
    "differential: OBJ files of every make are the same to tinyobjloader, coordinates within 4 ulp, or 6 of an "
    "exponent") {
  Dice dice(3);
  for (int i = 0; i < 400; ++i) {
    const std::string text = any_obj(dice);
    CAPTURE(text);
    const auto ours = read(text, "m.obj");
    INFO((ours ? "" : ours.error().message));
    REQUIRE(ours.ok());
    REQUIRE(tinyobj_excuse(text).empty());
    check_against_tinyobj(text, ours->mesh);
  }
}

TEST_CASE("differential: libadmesh reads STL files of every kind alike") {
  Dice dice(4);
  for (int i = 0; i < 100; ++i) {
    const auto facets = any_facets(dice);
    for (const std::string& file :
         {binary_stl(facets), ascii_stl(facets, "      vertex %.9g %.9g %.9g\n"),
          ascii_stl(facets, "vertex\t%.8E %.8E %.8E\r\n"), ascii_stl(facets, "  vertex %.50f %.50f %.50f\n")}) {
      const auto ours = read(file, "m.stl");
      REQUIRE(ours.ok());
      REQUIRE(admesh_excuse(file, facets.size()).empty());
      check_against_admesh(file, ours->mesh);
    }
  }
}

TEST_CASE("differential: tinyobjloader reads the OBJ files of the corpus alike, or a known reason applies") {
  compare_corpus(".obj", [](const std::string& text, const Mesh& ours) {
    const std::string_view excuse = tinyobj_excuse(text);
    if (excuse.empty()) check_against_tinyobj(text, ours);
    return excuse;
  });
}

TEST_CASE("differential: libadmesh reads the STL files of the corpus alike, or a known reason applies") {
  compare_corpus(".stl", [](const std::string& file, const Mesh& ours) {
    const std::string_view excuse = admesh_excuse(file, ours.triangles.size());
    if (excuse.empty()) check_against_admesh(file, ours);
    return excuse;
  });
}

TEST_CASE("differential: the known reasons are real") {
  const auto differs = [](const std::string& text) {
    const auto ours = read(text, "m.obj");
    REQUIRE(ours.ok());
    CHECK(!tinyobj_excuse(text).empty());
    const Mesh theirs = by_tinyobj(text, ours->mesh.positions);
    return ours->mesh.triangles != theirs.triangles || ours->mesh.positions != theirs.positions;
  };
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK(differs("\xEF\xBB\xBF" + corners + "f 1 2 3\n"));
  CHECK(differs(corners + "f 1 2 \\\n3\n"));
  CHECK(differs(corners + "\vf 1 2 3\n"));
  CHECK(differs(corners + "fo 1 2 3\n"));
  CHECK(differs(corners + "f 1 2 3 # one\n"));
  CHECK(differs(corners + "f 1 2 3 \x1A"));
  CHECK(differs(corners + "v 1 2 0." + std::string(400, '0') + "5e401\nf 1 2 3\n"));
}

}  // namespace meshgauge::api::test
