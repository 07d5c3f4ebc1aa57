#include "engine/tree/vicinity.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "shapes.h"

using namespace meshgauge;

namespace {

Box box_of(const Mesh& mesh, std::size_t t) {
  Box box;
  for (const std::uint32_t v : mesh.triangles[t]) box.extend(mesh.positions[v]);
  return box;
}

long double distance_of(const Box& a, const Box& b) {
  long double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const long double gap = std::max(
        {0.0L, static_cast<long double>(a.low[k]) - b.high[k], static_cast<long double>(b.low[k]) - a.high[k]});
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

struct Sought {
  Box box;
  double reach;
};

// Returns how many triangles are found, and checks that none of the others is within reach.
std::size_t count_near(const Mesh& mesh, const std::vector<Sought>& sought) {
  const MeshCells cells(mesh, bounding_box(mesh), Frame{}, never_interrupted);
  REQUIRE(cells.complete());
  Vicinity vicinity(cells);
  for (const Sought& s : sought) vicinity.add(s.box, s.reach);
  const auto found = vicinity.triangles(never_interrupted);
  REQUIRE(found);
  CHECK(std::is_sorted(found->begin(), found->end()));
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (std::binary_search(found->begin(), found->end(), t)) continue;
    for (const Sought& s : sought) CHECK(distance_of(box_of(mesh, t), s.box) > s.reach);
  }
  return found->size();
}

std::vector<Sought> boxes(std::size_t count, double size, double reach, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Sought> sought;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 at(unit(random), unit(random), unit(random));
    sought.push_back({{at, at + Vec3::Constant(size)}, reach});
  }
  return sought;
}

}  // namespace

TEST_CASE("vicinity: no triangle within reach of a box is left out, few or many boxes, a small or a large reach") {
  std::mt19937_64 random(61);
  for (const Mesh& mesh : {shapes::sphere(30), shapes::soup(500, random), shapes::grid(20), shapes::cube(1)}) {
    for (const std::size_t count : {1U, 16U, 17U, 200U}) {
      for (const double reach : {0.0, 1e-3, 0.1, 1.0}) (void)count_near(mesh, boxes(count, 0.01, reach, random));
    }
  }
}

TEST_CASE("vicinity: of a fine mesh it finds little more than what is near") {
  const Mesh mesh = shapes::sphere(60);
  const Vec3& top = mesh.positions[mesh.triangles[0][0]];
  CHECK(count_near(mesh, {{Box{top, top}, 0.01}}) < mesh.triangles.size() / 50);
}

TEST_CASE("vicinity: a reach that ends exactly at a triangle includes it, and the next larger gap does not") {
  Mesh mesh;
  mesh.positions = {{0.5, 0, 0}, {0.5, 1, 0}, {0.5, 0, 1}, {-1, -1, -1}, {-1, -1, -0.5}, {-1, -0.5, -1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Box at_origin{Vec3::Zero(), Vec3::Zero()};
  CHECK(count_near(mesh, {{at_origin, 0.5}}) == 1);
  CHECK(count_near(mesh, {{at_origin, 0.5 * (1 - 0x1p-40)}}) == 0);
}

TEST_CASE("vicinity: unused vertices may have any coordinates, and a flat mesh has cells too") {
  Mesh mesh = shapes::grid(10);
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  mesh.positions.insert(mesh.positions.end(), {Vec3::Constant(nan), Vec3::Constant(inf), Vec3::Constant(-inf)});
  const Vec3 corner = mesh.positions[mesh.triangles[0][0]];
  CHECK(count_near(mesh, {{Box{corner, corner}, 0}}) >= 1);
}

TEST_CASE("vicinity: an interruption is told") {
  const Mesh mesh = shapes::grid(80);
  const Interrupted interrupted = [] { return true; };
  const MeshCells cells(mesh, bounding_box(mesh), Frame{}, never_interrupted);
  Vicinity vicinity(cells);
  vicinity.add(bounding_box(mesh), 1);
  CHECK_FALSE(vicinity.triangles(interrupted));
  CHECK_FALSE(MeshCells(shapes::grid(100), bounding_box(mesh), Frame{}, interrupted).complete());
}
