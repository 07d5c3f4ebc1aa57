#include "check/html/render.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Pixel pixel(const Image& image, int x, int y) {
  Pixel rgba;
  const auto at =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  std::copy_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(at), 4, rgba.begin());
  return rgba;
}

Camera from_above(MeshView mesh, int width, int height) {
  return whole_view(mesh, Frame(bounding_box(mesh)), View{}, {}, width, height);
}

bool reddish(const Pixel& p) { return p[0] > 90 && p[0] > 2 * p[1] && p[0] > 2 * p[2]; }

Image picture(MeshView mesh, const Camera& camera, const std::function<double(const Vec3&)>& distance, double limit,
              std::size_t threads = 1) {
  ThreadPool pool(threads);
  return render(mesh, camera, {distance, {limit, true}, Inside::unknown}, pool);
}

}  // namespace

TEST_CASE("a point of a cloud has the colour of its own distance, without an outline") {
  Mesh cloud;
  cloud.positions = {Vec3(1, 5, 0), Vec3(9, 5, 0)};
  cloud.triangles = points_as_triangles(cloud.positions.size());
  const Camera camera = from_above(cloud, 200, 100);
  const Image image = picture(
      cloud, camera, [](const Vec3& p) { return p.x(); }, 9);
  const auto at = [&](std::size_t i) {
    const Seen seen = camera.see(cloud.positions[i]);
    return pixel(image, static_cast<int>(seen.x), static_cast<int>(seen.y));
  };
  const Pixel near = at(0), far = at(1);
  CHECK(near[3] == 255);
  CHECK(near[2] > near[1]);
  CHECK(far[0] + far[1] > 380);  // light yellow: at the limit
}

TEST_CASE("each pixel has the colour of its own place, within one triangle as well") {
  const Mesh mesh = shapes::triangle(Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(0, 10, 0));
  const Camera camera = from_above(mesh, 200, 200);
  const Image image = picture(
      mesh, camera, [](const Vec3& p) { return p.x(); }, 5);
  const auto at = [&](const Vec3& p) {
    const Seen seen = camera.see(p);
    return pixel(image, static_cast<int>(seen.x), static_cast<int>(seen.y));
  };
  CHECK(at(Vec3(9, 0.5, 0))[3] == 255);
  CHECK(at(Vec3(9, 9, 0))[3] == 0);
  CHECK(reddish(at(Vec3(7, 1, 0))));
  CHECK_FALSE(reddish(at(Vec3(4.5, 1, 0))));
  // Blue gives way to yellow towards the limit.
  const Pixel low = at(Vec3(0.5, 1, 0)), high = at(Vec3(4.8, 1, 0));
  CHECK(low[2] > low[1]);
  CHECK(high[1] > high[2]);
  CHECK(high[1] > low[1] + 80);
}

TEST_CASE("above the limit is hatched: light stripes beside dark ones") {
  const Mesh mesh = shapes::grid(1, 10);
  const Image image = picture(
      mesh, from_above(mesh, 100, 100), [](const Vec3&) { return 1.0; }, 0.5);
  int light = 0, dark = 0;
  for (int x = 20; x < 80; ++x) (pixel(image, x, 50)[1] > 80 ? light : dark)++;
  CHECK(light > 6);
  CHECK(dark > 20);
}

TEST_CASE("the place of the witness is the pixel that the camera says") {
  // A speck that alone is beyond the limit, on a large sphere far from the origin.
  const Mesh mesh = shapes::moved(shapes::sphere(40, 10), Vec3(1e7, -1e7, 1e7));
  const Vec3 witness = mesh.positions[900];
  const Frame frame(bounding_box(mesh));
  const ChosenView chosen =
      choose_view({mesh, witness}, std::nullopt, frame, (witness - Vec3(1e7, -1e7, 1e7)).normalized(), 2);
  const Camera camera = whole_view(mesh, frame, chosen.view, std::span(&witness, 1), 320, 240);
  const Image image = picture(
      mesh, camera, [&](const Vec3& p) { return (p - witness).norm() < 0.5 ? 1.0 : 0.0; }, 0.5);
  const Seen seen = camera.see(witness);
  int red = 0;
  double x = 0, y = 0;
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column) {
      const Pixel p = pixel(image, column, row);
      if (p[3] == 0 || p[0] < p[2] + 20) continue;
      ++red, x += column + 0.5, y += row + 0.5;
    }
  }
  REQUIRE(red > 10);
  CHECK(std::abs(x / red - seen.x) < 1.5);
  CHECK(std::abs(y / red - seen.y) < 1.5);
}

TEST_CASE("the same bits whatever the size of the pool") {
  const Mesh mesh = shapes::sphere(30);
  const Camera camera = from_above(mesh, 150, 110);
  const auto distance = [](const Vec3& p) { return p.x() * p.x(); };
  const Image one = picture(mesh, camera, distance, 0.3);
  CHECK(one.rgba == picture(mesh, camera, distance, 0.3, 4).rgba);
  CHECK(to_png(one) == to_png(picture(mesh, camera, distance, 0.3, 3)));
}

TEST_CASE("distances that are no numbers, a limit of 0, needles and huge coordinates give a picture") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double size : {1e-300, 1.0, 1e300}) {
    Mesh mesh = shapes::scaled(shapes::cube(1, Vec3(-0.5, -0.5, -0.5)), size);
    mesh.triangles.push_back({0, 1, 1});
    mesh.positions.push_back(mesh.positions[0] * (1 + 1e-15));
    mesh.triangles.push_back({0, 7, 8});
    const Image image = picture(
        mesh, from_above(mesh, 60, 60), [nan](const Vec3& p) { return p.x() > 0 ? nan : 0; }, 0);
    CHECK(pixel(image, 20, 30)[3] == 255);
    CHECK(pixel(image, 40, 30)[3] == 255);
  }
}

TEST_CASE("the side that is seen through a hole alone is found, and drawn darker") {
  Mesh mesh = shapes::sphere(30);
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return mesh.positions[t[0]].z() > 0.9; });
  const Camera camera = from_above(mesh, 120, 120);
  const Inside inside = inside_of(mesh, camera);
  CHECK(inside != Inside::unknown);
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  CHECK(inside_of(mesh, camera) != inside);
  CHECK(inside_of(mesh, camera) != Inside::unknown);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 2) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  CHECK(inside_of(mesh, camera) == Inside::unknown);

  Mesh whole = shapes::sphere(30);
  std::erase_if(whole.triangles, [&](const Triangle& t) { return whole.positions[t[0]].z() > 0.9; });
  ThreadPool pool(1);
  const auto middle = [&](Inside dark) {
    return pixel(render(whole, camera, {[](const Vec3&) { return 0.5; }, {1, true}, dark}, pool), 60, 60)[1];
  };
  CHECK(middle(inside) < 0.8 * middle(Inside::unknown));
}

TEST_CASE("without a distance the surface is grey, and where nothing is has no depth") {
  const Mesh mesh = shapes::sphere(20);
  const Camera camera = from_above(mesh, 60, 60);
  ThreadPool pool(2);
  const Rendered made = render_with_depth(mesh, camera, {{}, {1, true}, Inside::unknown}, pool);
  const Pixel middle = pixel(made.image, 30, 30);
  CHECK(middle[3] == 255);
  CHECK(std::abs(middle[0] - middle[2]) < 24);
  REQUIRE(made.depth.size() == 60 * 60);
  CHECK(made.depth[30 * 60 + 30] > made.depth[30 * 60 + 12]);
  CHECK(made.depth[0] == -std::numeric_limits<float>::infinity());
}
