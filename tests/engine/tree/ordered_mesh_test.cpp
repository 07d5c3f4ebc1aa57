#include "engine/tree/ordered_mesh.h"

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;

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
