// One face of any corners, split directly: n - 2 triangles whose border is its outline, the same twice, a deviation
// that is a number. Of a planar face on a grid that is not counted as crossing itself, no triangle is turned against
// the others, so that they are its surface (api/formats/polygons/ear_clipping.h).
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <utility>

#include "api/formats/polygons/polygons.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

enum class Layout { grid, raised_grid, doubles };

struct Face {
  Layout layout = Layout::grid;
  std::vector<Vec3> corners;
};

// The first byte chooses the layout and the size; then come a byte, or a double, for each coordinate.
Face face_of(const std::uint8_t* data, std::size_t size) {
  Face face;
  if (size == 0) return face;
  face.layout = static_cast<Layout>(data[0] % 3);
  const double unit = std::ldexp(1, data[0] / 3 % 2 == 0 ? 0 : 3 * (data[0] - 128));
  ++data, --size;
  const auto grid = [&](std::size_t i) { return unit * static_cast<std::int8_t>(data[i]); };
  const std::size_t stride = face.layout == Layout::doubles ? 24 : (face.layout == Layout::grid ? 2 : 3);
  for (; size >= stride; data += stride, size -= stride) {
    Vec3 p = Vec3::Zero();
    if (face.layout == Layout::doubles) {
      std::memcpy(p.data(), data, stride);
      for (double& x : p) x = std::isfinite(x) ? x : 1;
    } else {
      p = {grid(0), grid(1), face.layout == Layout::grid ? 0 : grid(2)};
    }
    face.corners.push_back(p);
  }
  return face;
}

// Corner i is vertex i. nullopt: refused, as too much work.
std::optional<api::ReadMesh> split(const Face& face) {
  api::ReadMesh read;
  read.mesh.positions = face.corners;
  api::Faces faces(read.mesh.triangles);
  faces.begin();
  for (std::uint32_t i = 0; i < face.corners.size(); ++i) faces.add(i);
  faces.end();
  const api::ReadLimits limits;
  const auto done = api::split_polygons(api::Source{{}, "a", limits}, faces.runs(), read);
  if (done) return read;
  require_answer(done.error());
  return std::nullopt;
}

bool borders(const std::vector<Triangle>& triangles, std::uint32_t corners) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  const auto add = [&](std::uint32_t a, std::uint32_t b, int times) {
    edges[{a, b}] += times;
    edges[{b, a}] -= times;
  };
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) add(t[k], t[(k + 1) % 3], 1);
  }
  for (std::uint32_t i = 0; i < corners; ++i) add(i, (i + 1) % corners, -1);
  for (const auto& [edge, times] : edges) {
    if (times != 0) return false;
  }
  return true;
}

// Exact: the coordinates are of eight bits.
bool turn_one_way(const Mesh& mesh) {
  bool left = false, right = false;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    left = left || area > 0;
    right = right || area < 0;
  }
  return !left || !right;
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(polygon) {
  using namespace meshgauge::fuzz;
  const Face face = face_of(data, size);
  if (face.corners.size() < 3) return 0;
  const auto once = split(face), again = split(face);
  require(once.has_value() == again.has_value(), "the same answer twice");
  if (!once) return 0;
  const auto corners = static_cast<std::uint32_t>(face.corners.size());
  require(once->mesh.triangles == again->mesh.triangles, "the same triangles twice");
  require(once->mesh.triangles.size() == corners - 2, "n - 2 triangles");
  require(borders(once->mesh.triangles, corners), "the outline is the border");
  const auto& notes = once->notes.polygons;
  require(notes.count == (corners > 3 ? 1 : 0) && notes.concave + notes.self_crossing <= 1, "one face");
  require(notes.largest_deviation >= 0, "the deviation is a number");
  if (face.layout != Layout::grid) return 0;
  require(notes.largest_deviation == 0 && notes.non_planar == 0, "a grid is planar");
  require(notes.self_crossing != 0 || turn_one_way(once->mesh), "the triangles turn one way");
  return 0;
}
