#include "engine/morton.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "shapes.h"

using namespace meshgauge;

TEST_CASE("the order is a permutation that keeps neighbours together") {
  std::mt19937_64 random(41);
  Mesh mesh = shapes::grid(64);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  const auto order = morton_order(mesh, bounding_box(mesh));
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < sorted.size(); ++i) REQUIRE(sorted[i] == i);
  double steps = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    steps += (MeshView(mesh).corner(order[i], 0) - MeshView(mesh).corner(order[i - 1], 0)).norm();
  }
  CHECK(steps / static_cast<double>(order.size()) < 4.0 / 64);  // a shuffled order has steps of about 0.5
}

TEST_CASE("one triangle, and triangles all in one place") {
  const Mesh point = shapes::triangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0});
  CHECK(morton_order(point, bounding_box(point)).size() == 1);
  Mesh mesh = shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.triangles.resize(100, mesh.triangles[0]);
  CHECK(morton_order(mesh, bounding_box(mesh)).size() == 100);
}
