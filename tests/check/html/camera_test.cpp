#include "check/html/camera.h"

#include <cmath>

#include <Eigen/Geometry>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Frame frame_of(MeshView mesh) { return Frame(bounding_box(mesh)); }

// A cube with a plate over its upper face, so that no view from above sees the face.
Mesh roofed() {
  Mesh mesh = shapes::cube(1);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3& p : shapes::grid(1, 9).positions) mesh.positions.push_back(p + Vec3(-4, -4, 1.5));
  mesh.triangles.push_back({first, first + 1, first + 3});
  mesh.triangles.push_back({first, first + 3, first + 2});
  return mesh;
}

}  // namespace

TEST_CASE("the whole mesh and the points are seen, with a margin, and no smaller than need be") {
  for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1e9, -1e9, 5e8)}) {
    const Mesh mesh = shapes::moved(shapes::sphere(20, 3), offset);
    const View view = choose_view({mesh, mesh.positions[100]}, std::nullopt, frame_of(mesh), Vec3::UnitX(), 2).view;
    const Vec3 outside = offset + Vec3(0, 0, 5);
    const Camera camera = whole_view(mesh, frame_of(mesh), view, std::span(&outside, 1), 400, 300);
    Box seen;
    for (const Vec3& p : mesh.positions) seen.extend(Vec3(camera.see(p).x, camera.see(p).y, 0));
    seen.extend(Vec3(camera.see(outside).x, camera.see(outside).y, 0));
    CHECK(seen.low.x() > 10);
    CHECK(seen.low.y() > 10);
    CHECK(seen.high.x() < 390);
    CHECK(seen.high.y() < 290);
    CHECK(seen.high.y() - seen.low.y() > 250);
  }
}

TEST_CASE("a pixel is as long as the picture says") {
  const Mesh mesh = shapes::scaled(shapes::cube(1), 48);
  const View from_above{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  const Camera camera = whole_view(mesh, frame_of(mesh), from_above, {}, 200, 200);
  const double width = camera.see(Vec3(48, 0, 0)).x - camera.see(Vec3(0, 0, 0)).x;
  CHECK(width * camera.pixel_size() == doctest::Approx(48));
  const Camera close = close_view(camera, Vec3(48, 48, 48), 6, 100, 80);
  CHECK(close.see(Vec3(48, 48, 48)).x == doctest::Approx(50));
  CHECK(close.see(Vec3(48, 48, 48)).y == doctest::Approx(40));
  CHECK(close.see(Vec3(48, 42, 48)).y == doctest::Approx(80));  // y points down
}

TEST_CASE("the view has nothing between the viewer and the witness") {
  const Mesh sphere = shapes::sphere(24);
  for (const std::size_t vertex : {30U, 400U, 700U, 1100U}) {
    const Vec3 p = sphere.positions[vertex];
    const ChosenView chosen = choose_view({sphere, p}, std::nullopt, frame_of(sphere), p.normalized(), 2);
    CHECK_FALSE(chosen.hidden);
    CHECK(chosen.view.toward.dot(p) > 0.3);  // the near side
    CHECK_FALSE(covered(sphere, frame_of(sphere), chosen.view, p));
    View behind = chosen.view;
    behind.toward *= -1, behind.right *= -1;
    CHECK(covered(sphere, frame_of(sphere), behind, p));
  }
}

TEST_CASE("a witness under a roof is looked at from the side, one inside of a closed part is hidden") {
  const Mesh mesh = roofed();
  const ChosenView chosen = choose_view({mesh, Vec3(0.5, 0.5, 1)}, std::nullopt, frame_of(mesh), Vec3::UnitZ(), 2);
  CHECK_FALSE(chosen.hidden);
  CHECK(std::abs(chosen.view.toward.z()) < 0.5);
  CHECK(choose_view({mesh, Vec3(0.5, 0.5, 0.5)}, std::nullopt, frame_of(mesh), Vec3::Zero(), 2).hidden);
}

TEST_CASE("the axes of a view are orthonormal, and up is up") {
  for (const int up : {1, 2}) {
    const Mesh mesh = shapes::sphere(8);
    const View view =
        choose_view({mesh, Vec3(0.2, -1, 0.5).normalized()}, std::nullopt, frame_of(mesh), Vec3::Zero(), up).view;
    CHECK(view.right.norm() == doctest::Approx(1));
    CHECK(view.up.norm() == doctest::Approx(1));
    CHECK(std::abs(view.right.dot(view.up)) < 1e-12);
    CHECK(view.right.cross(view.up).dot(view.toward) == doctest::Approx(1));
    CHECK(view.up[up] > 0);
    CHECK(std::abs(view.right[up]) < 1e-12);
  }
}

TEST_CASE("a mesh that is one point or one line has a finite camera") {
  for (const Mesh& mesh : {shapes::triangle(Vec3(5, 5, 5), Vec3(5, 5, 5), Vec3(5, 5, 5)),
                           shapes::triangle(Vec3(0, 0, 0), Vec3(1e300, 0, 0), Vec3(5e299, 0, 0))}) {
    const View view = choose_view({mesh, mesh.positions[0]}, std::nullopt, frame_of(mesh), Vec3::Zero(), 2).view;
    const Camera camera = whole_view(mesh, frame_of(mesh), view, {}, 100, 100);
    for (const Vec3& p : mesh.positions) {
      CHECK(std::isfinite(camera.see(p).x));
      CHECK(std::abs(camera.see(p).y - 50) < 51);
    }
  }
}

TEST_CASE("of the views that show the witness one is taken that shows the nearest point as well, if there is one") {
  const Mesh spike = shapes::sphere(24), ball = shapes::sphere(24);
  const Vec3 out(0, 0, 1.5), foot(0, 0, 1);  // the spike's end is seen from beyond the horizon of its foot
  const ChosenView both = choose_view({spike, out}, Sight{ball, foot}, frame_of(spike), Vec3::UnitX(), 2);
  CHECK_FALSE(both.hidden);
  CHECK_FALSE(covered(ball, frame_of(ball), both.view, foot));
  const ChosenView first_alone =
      choose_view({spike, out}, Sight{ball, Vec3::Zero()}, frame_of(spike), Vec3::UnitX(), 2);
  CHECK_FALSE(first_alone.hidden);
}
