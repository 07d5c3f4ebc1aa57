#include "engine/mesh/adjacency.h"

#include <doctest/doctest.h>

#include <random>
#include <set>

#include "shapes.h"

using namespace meshgauge;

namespace {

// Returns the triangles around an edge, in the order of the ring.
std::set<std::uint32_t> ring(const Adjacency& adjacency, std::uint32_t triangle, std::uint32_t edge) {
  std::set<std::uint32_t> seen;
  Adjacency::Edge e{triangle, edge};
  do {
    seen.insert(e.triangle);
    e = adjacency.next_around(e.triangle, e.edge);
  } while (e.triangle != triangle || e.edge != edge);
  return seen;
}

}  // namespace

TEST_CASE("adjacency: in a closed surface every edge has two triangles, welded or not") {
  Mesh cube = shapes::cube();
  Mesh soup;
  for (std::uint32_t t = 0; t < cube.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) soup.positions.push_back(MeshView(cube).corner(t, k));
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  for (const Mesh& mesh : {cube, soup}) {
    ThreadPool pool(1);
    const Adjacency adjacency(mesh, pool);
    for (std::uint32_t t = 0; t < 12; ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) CHECK(ring(adjacency, t, e).size() == 2);
    }
  }
}

TEST_CASE("adjacency: borders, three triangles at an edge, zeros of either sign") {
  Mesh mesh = shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.positions.insert(mesh.positions.end(), {Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(-0.0, 0, -0.0)});
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {5, 1, 4}};  // three around the edge 0-1, one through a copy with -0
  ThreadPool pool(1);
  const Adjacency adjacency(mesh, pool);
  CHECK(ring(adjacency, 0, 0) == std::set<std::uint32_t>{0, 1, 2});
  CHECK(ring(adjacency, 2, 0) == std::set<std::uint32_t>{0, 1, 2});
  CHECK(ring(adjacency, 0, 1) == std::set<std::uint32_t>{0});
}

TEST_CASE("adjacency: the rings do not depend on the pool, and an interruption leaves it incomplete") {
  std::mt19937_64 random(91);
  Mesh mesh = shapes::sphere(80);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (random() % 4 != 0) continue;
      const Vec3 copy = mesh.positions[v];
      v = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(copy);
    }
  }
  ThreadPool one(1);
  const Adjacency alone(mesh, one);
  for (const std::size_t size : {2U, 3U, 7U}) {
    ThreadPool pool(size);
    const Adjacency together(mesh, pool);
    REQUIRE(together.complete());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        const auto a = alone.next_around(t, e), b = together.next_around(t, e);
        CHECK((a.triangle == b.triangle && a.edge == b.edge));
      }
    }
    CHECK_FALSE(Adjacency(mesh, pool, [] { return true; }).complete());
  }
}
