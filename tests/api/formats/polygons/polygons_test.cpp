// Polygons against exact references: the surface of planar faces, triangle by triangle, in integers.
#include "api/formats/polygons/polygons.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "tests/api/formats/files.h"
#include "tests/api/formats/random_polygons.h"
#include "tests/today.h"

namespace meshgauge::api::test {
namespace {

using fuzz::Dice;
using namespace std::string_literals;
using Corners = std::array<GridPoint, 3>;

std::string number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

std::string as_obj(const std::vector<Vec3>& corners) {
  std::string text, face = "f";
  for (std::size_t i = 0; i < corners.size(); ++i) {
    text += "v " + number(corners[i].x()) + " " + number(corners[i].y()) + " " + number(corners[i].z()) + "\n";
    face += " " + std::to_string(i + 1);
  }
  return text + face + "\n";
}

Result<ReadMesh> read_face(const std::vector<Vec3>& corners) { return read(as_obj(corners), "m.obj"); }

std::vector<Vec3> placed(const Outline& outline, const Placing& placing) {
  std::vector<Vec3> corners;
  for (const GridPoint& p : outline) corners.push_back(placing(p));
  return corners;
}

// Returns true when p is on the surface: inside the outline or on it.
bool holds(const Outline& outline, const GridPoint& p) {
  int winding = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const GridPoint &a = outline[i], &b = outline[(i + 1) % outline.size()];
    if (on_segment(p, a, b)) return true;
    if (a.y <= p.y && b.y > p.y && twice_area(a, b, p) > 0) ++winding;
    if (b.y <= p.y && a.y > p.y && twice_area(a, b, p) < 0) --winding;
  }
  return winding != 0;
}

Outline times(const Outline& outline, std::int64_t factor) {
  Outline out;
  for (const GridPoint& p : outline) out.push_back({factor * p.x, factor * p.y});
  return out;
}

// Whether the triangle, or the segment that it is, lies in the surface: no edge of the outline leads through it, and it
// has points there.
bool lies_in(const Outline& border, const Outline& outline6, const Corners& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    const GridPoint &a = t[k], &b = t[(k + 1) % 3];
    if (!holds(outline6, {3 * (a.x + b.x), 3 * (a.y + b.y)})) return false;
    for (std::size_t i = 0; i < border.size(); ++i) {
      const GridPoint &c = border[i], &d = border[(i + 1) % border.size()];
      if (cross_inside(a, b, c, d) && twice_area(t[0], t[1], t[2]) != 0) return false;
    }
  }
  return holds(outline6, {2 * (t[0].x + t[1].x + t[2].x), 2 * (t[0].y + t[1].y + t[2].y)});
}

// Returns true when an edge of one triangle has the other triangle on its outer side.
bool are_apart(const Corners& a, const Corners& b) {
  const auto separates = [](const Corners& t, const Corners& other) {
    const std::int64_t side = twice_area(t[0], t[1], t[2]) > 0 ? 1 : -1;
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::all_of(other.begin(), other.end(),
                      [&](const GridPoint& p) { return side * twice_area(t[k], t[(k + 1) % 3], p) <= 0; })) {
        return true;
      }
    }
    return false;
  };
  return separates(a, b) || separates(b, a);
}

// The triangles are a disk whose border is the outline: each of its edges once, each other edge once either way.
bool is_disk(const std::vector<Triangle>& triangles, std::uint32_t corners) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      ++edges[{a, b}];
      --edges[{b, a}];
    }
  }
  for (std::uint32_t i = 0; i < corners; ++i) {
    const std::uint32_t next = i + 1 == corners ? 0 : i + 1;
    --edges[{i, next}];
    ++edges[{next, i}];
  }
  return std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 0; });
}

// Returns the defect of the triangles as the surface of the outline; empty: none. Together: all lie in the surface, do
// not overlap, and have its area, so they are the surface; and the outline's edges are edges of theirs.
std::string fault_of(const Outline& border, const Outline& outline, const std::vector<Triangle>& triangles) {
  if (triangles.size() + 2 != outline.size()) return "the number of triangles";
  if (!is_disk(triangles, static_cast<std::uint32_t>(outline.size())))
    return "not a disk with the outline as its border";
  const Outline outline6 = times(outline, 6);
  std::vector<Corners> with_area;
  std::int64_t area = 0;
  for (const Triangle& t : triangles) {
    const Corners corners = {outline[t[0]], outline[t[1]], outline[t[2]]};
    const std::int64_t its = twice_area(corners[0], corners[1], corners[2]);
    area += std::abs(its);
    if (its != 0) with_area.push_back(corners);
    if (!lies_in(border, outline6, corners)) return "a triangle sticks out";
  }
  if (area != std::abs(twice_area(outline))) return "the area";
  for (std::size_t i = 0; i < with_area.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!are_apart(with_area[i], with_area[j])) return "two triangles overlap";
    }
  }
  return {};
}

std::string text_of(const Outline& outline) {
  std::string text;
  for (const GridPoint& p : outline) text += "(" + std::to_string(p.x) + "," + std::to_string(p.y) + ")";
  return text;
}

std::vector<std::array<std::uint32_t, 3>> fan(std::uint32_t corners) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 1; i + 1 < corners; ++i) triangles.push_back({0, i, i + 1});
  return triangles;
}

TEST_CASE("polygons: planar faces become exactly their surface") {
  std::size_t concave = 0;
  for (const std::uint64_t seed : todays_part(20'000, 4)) {
    Dice dice(seed);
    const OutlineKind kind = dice.pick(kOutlineKinds);
    Outline outline = random_outline(kind, dice);
    const Outline border = outline;
    const bool plain = dice.chance(0.4);
    if (!plain && dice.chance(0.5)) add_spikes(outline, dice);
    if (!plain && dice.chance(0.5)) add_collinear_corners(outline, dice);
    if (!plain && dice.chance(0.5)) add_repeated_corners(outline, dice);
    turn_around(outline, dice);
    const auto result = read_face(placed(outline, random_placing(dice)));
    CAPTURE(seed);
    CAPTURE(static_cast<int>(kind));
    CAPTURE(text_of(outline));
    REQUIRE(result.ok());
    REQUIRE_EQ(fault_of(border, outline, result->mesh.triangles), "");
    const PolygonNotes& notes = result->notes.polygons;
    REQUIRE_EQ(notes.count, outline.size() > 3 ? 1 : 0);
    REQUIRE_EQ(notes.self_crossing, 0);
    REQUIRE_EQ(notes.non_planar, 0);
    concave += notes.concave;
    if (kind == OutlineKind::convex && plain) {
      REQUIRE_EQ(notes.concave, 0);
      REQUIRE(result->mesh.triangles == fan(static_cast<std::uint32_t>(outline.size())));
    }
  }
  CHECK(concave > 2'800);
}

TEST_CASE("polygons: a face that runs there and back has no area") {
  for (std::uint64_t seed = 0; seed < 2'000; ++seed) {
    Dice dice(seed);
    Outline outline;
    for (int i = 0, x = 0; i < 4; ++i, x += dice.between(1, 9)) outline.push_back({12 * x, 12 * dice.between(-9, 9)});
    outline.resize(static_cast<std::size_t>(dice.between(2, 4)));
    for (std::size_t i = outline.size() - 1; i-- > 1;) outline.push_back(GridPoint(outline[i]));
    const Outline border = outline;
    if (dice.chance(0.5)) add_collinear_corners(outline, dice);
    if (dice.chance(0.7)) add_repeated_corners(outline, dice);
    turn_around(outline, dice);
    if (outline.size() < 3) continue;
    const auto result = read_face(placed(outline, random_placing(dice)));
    CAPTURE(seed);
    CAPTURE(text_of(outline));
    REQUIRE(result.ok());
    REQUIRE_EQ(fault_of(border, outline, result->mesh.triangles), "");
    REQUIRE_EQ(result->notes.polygons.self_crossing, 0);
  }
}

ReadMesh read_or_fail(const std::string& text, const std::string& name) {
  auto result = read(text, name);
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(*result);
}

TEST_CASE("polygons: a concave face is the same in OBJ, OFF and PLY, also before its vertices") {
  const std::string corners = "0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n";
  std::string vertices;
  for (const char* corner : {"0 0 0", "4 0 0", "4 4 0", "2 1 0", "0 4 0"}) vertices += "v " + (corner + "\n"s);
  const std::string ply = "ply\nformat ascii 1.0\n";
  const std::string vertex = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  const ReadMesh obj = read_or_fail(vertices + "f 1 2 3 4 5\n", "m.obj");
  CHECK(fault_of({{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}}, {{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}},
                 obj.mesh.triangles) == "");
  CHECK(obj.notes.polygons == PolygonNotes{1, 1, 0, 0, 0});
  for (const auto& [text, name] :
       {std::pair("f 1 2 3 4 5\n" + vertices, "m.obj"), std::pair("OFF\n5 1 0\n" + corners + "5 0 1 2 3 4\n", "m.off"),
        std::pair(ply + vertex + face + "end_header\n" + corners + "5 0 1 2 3 4\n", "m.ply"),
        std::pair(ply + face + vertex + "end_header\n5 0 1 2 3 4\n" + corners, "m.ply")}) {
    CAPTURE(name);
    const ReadMesh other = read_or_fail(text, name);
    CHECK(other.mesh.triangles == obj.mesh.triangles);
    CHECK(other.notes.polygons == obj.notes.polygons);
  }
}

TEST_CASE("polygons: faces of any number of corners keep their places among the triangles") {
  std::string text;
  for (int i = 0; i < 8; ++i) text += "v " + std::to_string(i % 4) + " " + std::to_string(i / 4) + " 0\n";
  const ReadMesh read =
      read_or_fail(text + "f 1 2 5\nf 1 2 6 5\nf 2 3 7 6\nf 2 3 7\nf 1 3 7 6 5\nf 3 4 8 7\n", "m.obj");
  CHECK(read.mesh.triangles == std::vector<Triangle>{{0, 1, 4},
                                                     {0, 1, 5},
                                                     {0, 5, 4},
                                                     {1, 2, 6},
                                                     {1, 6, 5},
                                                     {1, 2, 6},
                                                     {0, 2, 6},
                                                     {0, 6, 5},
                                                     {0, 5, 4},
                                                     {2, 3, 7},
                                                     {2, 7, 6}});
  CHECK(read.notes.polygons == PolygonNotes{4, 0, 0, 0, 0});
}

TEST_CASE("polygons: a face that crosses itself is counted and split") {
  const auto crossing = [](const Outline& outline) {
    const auto result = read_face(placed(outline, {}));
    REQUIRE(result.ok());
    CHECK(result->notes.polygons.self_crossing == 1);
    CHECK(result->notes.polygons.concave == 0);
    CHECK(is_disk(result->mesh.triangles, static_cast<std::uint32_t>(outline.size())));
    std::int64_t area = 0;
    for (const Triangle& t : result->mesh.triangles)
      area += std::abs(twice_area(outline[t[0]], outline[t[1]], outline[t[2]]));
    return area;
  };
  crossing({{0, 0}, {4, 4}, {4, 0}, {0, 4}});                 // a bow tie
  crossing({{0, 10}, {6, -8}, {-10, 3}, {10, 3}, {-6, -8}});  // a pentagram
  // Two outlines that cross at a corner of both: each is filled, though one is wound the other way.
  CHECK(crossing({{4, 4}, {2, 6}, {0, 4}, {2, 2}, {4, 4}, {6, 7}, {8, 4}, {6, 3}}) == 32);
}

TEST_CASE("polygons: a tiny crossing moves the surface by as little") {
  // The notch reaches the lower edge, and 1e-9 beyond.
  const auto result = read_face({{0, 0, 0}, {8, 0, 0}, {8, 4, 0}, {5, 4, 0}, {4, -1e-9, 0}, {3, 4, 0}, {0, 4, 0}});
  REQUIRE(result.ok());
  double area = 0;
  for (std::size_t t = 0; t < result->mesh.triangles.size(); ++t) {
    const MeshView mesh(result->mesh);
    area += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm() / 2;
  }
  CHECK(area == doctest::Approx(28).epsilon(1e-8));
  CHECK(result->notes.polygons.self_crossing == 1);
}

TEST_CASE("polygons: a polyline there and back gives its segments") {
  const auto result = read_face({{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {1, 0, 0}});
  REQUIRE(result.ok());
  CHECK(count_degenerate(result->mesh) == 2);
  CHECK(read_face({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {2, 2, 2}, {2, 2, 2}})->notes.polygons ==
        PolygonNotes{1, 0, 0, 0, 0});
}

TEST_CASE("polygons: a face of edges far below its coordinates has a plane") {
  for (const double edge : {1.0, 1e-80, 1e-90, 1e-110}) {
    CAPTURE(edge);
    std::vector<Vec3> corners;
    for (const auto& [y, z] : {std::pair(0, 0), {4, 0}, {4, 4}, {2, 1}, {0, 4}}) {
      corners.emplace_back(1, edge * y, edge * z);
    }
    const auto result = read_face(corners);
    REQUIRE(result.ok());
    CHECK(result->notes.polygons == PolygonNotes{1, 1, 0, 0, 0});
    const Outline outline = {{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}};
    CHECK(fault_of(outline, outline, result->mesh.triangles) == "");
  }
}

TEST_CASE("polygons: planar faces stay so when their coordinates are printed with six digits") {
  Dice dice(5);
  for (int round = 0; round < 2000; ++round) {
    const Vec3 right = Vec3(dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1)).normalized();
    const Vec3 up = right.cross(Vec3(dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1))).normalized();
    const Vec3 origin(dice.uniform(-3, 3), dice.uniform(-3, 3), dice.uniform(-3, 3));
    std::string text;
    for (const auto& [x, y] : {std::pair(0, 0), {2, 0}, {3, 1}, {2, 3}, {0, 2}}) {
      const Vec3 p = origin + x * right + y * up;
      char line[100];
      std::snprintf(line, sizeof line, "v %.6g %.6g %.6g\n", p.x(), p.y(), p.z());
      text += line;
    }
    const auto five = read(text + "f 1 2 3 4 5\n", "m.obj"), four = read(text + "f 1 2 3 4\n", "m.obj");
    REQUIRE(five.ok());
    REQUIRE(four.ok());
    CHECK(five->notes.polygons.non_planar + four->notes.polygons.non_planar == 0);
    CHECK(five->notes.polygons.largest_deviation > 0);
  }
}

TEST_CASE("polygons: a face that takes too long is refused by its size and first vertex") {
  std::string text = "OFF\n20000 1 0\n", face = "20000";
  Dice dice(7);
  for (int i = 0; i < 20'000; ++i) {
    text += std::to_string(dice.below(1'000'000)) + " " + std::to_string(dice.below(1'000'000)) + " 0\n";
    face += " " + std::to_string(i);
  }
  const auto result = read(text + face + "\n", "m.off");
  REQUIRE(!result.ok());
  CHECK(result.error().code == ErrorCode::too_large);
  CHECK(contains(result.error().message,
                 "the face of 20000 corners that begins with vertex 0 (counted from 0) of 'a': "));
}

}  // namespace
}  // namespace meshgauge::api::test
