#include "engine/tree/ordered_mesh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "shapes.h"

using namespace meshgauge;

namespace {

LargeArray<std::uint32_t> order_of(const Mesh& mesh, std::size_t threads = 1) {
  Control control;
  ThreadPool pool(threads);
  return curve_order(mesh, {}, bounding_box(mesh), control, pool);
}

void check_permutation(const LargeArray<std::uint32_t>& order, std::size_t size) {
  LargeArray<std::uint32_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  REQUIRE(sorted.size() == size);
  for (std::uint32_t i = 0; i < sorted.size(); ++i) REQUIRE(sorted[i] == i);
}

double mean_step(const Mesh& mesh, const LargeArray<std::uint32_t>& order) {
  double steps = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    steps += (MeshView(mesh).corner(order[i], 0) - MeshView(mesh).corner(order[i - 1], 0)).norm();
  }
  return steps / static_cast<double>(order.size());
}

Mesh shuffled(Mesh mesh, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  return mesh;
}

}  // namespace

TEST_CASE("curve order: a permutation that keeps neighbours together, the same for any number of threads") {
  const Mesh mesh = shuffled(shapes::grid(200), 41);
  const auto order = order_of(mesh);
  check_permutation(order, mesh.triangles.size());
  CHECK(mean_step(mesh, order) < 2.0 / 200);  // a shuffled order has steps of about 0.5
  CHECK(order_of(mesh, 2) == order);
  CHECK(order_of(mesh, 4) == order);
}

TEST_CASE("curve order: triangles that share a cell are in order, too") {
  Mesh mesh = shapes::moved(shapes::scaled(shapes::grid(60), 1e-7), {0.3, 0.3, 0.3});  // all in a cell of the unit cube
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {Vec3(-1, -1, -1), Vec3(1, 1, 1)});
  mesh.triangles.push_back({first, first + 1, first});
  mesh = shuffled(mesh, 42);
  const auto order = order_of(mesh);
  check_permutation(order, mesh.triangles.size());
  const auto apart = std::count_if(order.begin() + 1, order.end(), [&](const std::uint32_t& t) {
    return (MeshView(mesh).corner(t, 0) - MeshView(mesh).corner(*(&t - 1), 0)).norm() > 1e-8;
  });
  CHECK(apart < 50);
}

TEST_CASE("curve order: one triangle, and equal triangles") {
  CHECK(order_of(shapes::triangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0})).size() == 1);
  Mesh mesh = shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.triangles.resize(5000, mesh.triangles[0]);
  check_permutation(order_of(mesh), 5000);
}

TEST_CASE("curve order: extents from the smallest to the largest number") {
  for (const double scale : {5e-324, 1e-310, 1e-300, 1e300}) {
    check_permutation(order_of(shapes::scaled(shapes::grid(30), scale)), shapes::grid(30).triangles.size());
  }
}

TEST_CASE("curve order: ordering stops when it is interrupted") {
  const Mesh mesh = shapes::grid(300);
  ThreadPool pool(1);
  for (const std::uint64_t check : {1UL, 2UL, 3UL}) {
    Control control;
    control.cancel_at_check(check);
    CHECK(curve_order(mesh, {}, bounding_box(mesh), control, pool).empty());
  }
}

TEST_CASE("an ordered mesh has the same triangles, in the frame, and no unused vertex") {
  std::mt19937_64 random(51);
  for (Mesh mesh : {shapes::sphere(20), shapes::soup(300, random), shapes::moved(shapes::cube(), {1e6, 0, 0})}) {
    mesh.positions.push_back(Vec3(1e9, std::nan(""), 0));  // unused
    const Box box = bounding_box(mesh);
    const Frame frame(box);
    Control control;
    ThreadPool pool(1);
    const OrderedMesh ordered(mesh, {}, box, frame, control, pool);
    REQUIRE(ordered.complete());
    REQUIRE(ordered.triangles.size() == mesh.triangles.size());
    CHECK(ordered.positions.size() < mesh.positions.size());
    std::vector<int> seen(mesh.triangles.size());
    for (std::size_t t = 0; t < ordered.triangles.size(); ++t) {
      ++seen[ordered.original[t]];
      for (int i = 0; i < 3; ++i) {
        CHECK(ordered.view().corner(t, i) == frame.to_frame(MeshView(mesh).corner(ordered.original[t], i)));
      }
    }
    for (const int count : seen) REQUIRE(count == 1);
    CHECK(ordered.box.low == bounding_box(ordered.view()).low);
    CHECK(ordered.box.high == bounding_box(ordered.view()).high);
  }
}

TEST_CASE("ordering a mesh stops when it is interrupted") {
  const Mesh mesh = shapes::sphere(150);
  Control control;
  ThreadPool pool(1);
  control.cancel();
  CHECK_FALSE(OrderedMesh(mesh, {}, bounding_box(mesh), Frame(bounding_box(mesh)), control, pool).complete());
}
