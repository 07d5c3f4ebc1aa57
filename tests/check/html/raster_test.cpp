#include "check/html/raster.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

// One unit a pixel, x to the right, y up, the origin in the lower left corner.
Camera plain(int width, int height) { return {Frame(), View{}, Vec3(0.5 * width, 0.5 * height, 0), 1, width, height}; }

std::size_t covered_samples(const Samples& samples) {
  return static_cast<std::size_t>(
      std::count_if(samples.triangle.begin(), samples.triangle.end(), [](auto t) { return t != Samples::kNone; }));
}

}  // namespace

TEST_CASE("a triangle covers the pixels whose middle it holds, and no other") {
  const Mesh mesh = shapes::triangle(Vec3(1, 1, 0), Vec3(7, 1, 0), Vec3(1, 7, 0));
  const Samples samples = rasterise(mesh, plain(9, 9));
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const double px = x + 0.5, py = 9 - (y + 0.5);
      const bool inside = px >= 1 && py >= 1 && px + py <= 8;
      CAPTURE(x);
      CAPTURE(y);
      CHECK((samples.triangle[samples.at(x, y)] == 0) == inside);
    }
  }
}

TEST_CASE("a point of a cloud is a square, the nearer one before the farther, and those outside are not drawn") {
  Mesh cloud;
  cloud.positions = {Vec3(4.5, 4.5, 0), Vec3(6.5, 4.5, 1), Vec3(-90, 4, 0), Vec3(1e9, 4, 0)};
  cloud.triangles = points_as_triangles(cloud.positions.size());
  const Samples samples = rasterise(cloud, plain(20, 9));
  CHECK(covered_samples(samples) == kPointSize * (kPointSize + 2));
  CHECK(samples.triangle[samples.at(3, 4)] == 0);
  CHECK(samples.triangle[samples.at(5, 4)] == 1);
  CHECK(samples.triangle[samples.at(12, 4)] == Samples::kNone);
}

TEST_CASE("both sides are seen alike, and a degenerate triangle is not") {
  const Mesh front = shapes::triangle(Vec3(1, 1, 0), Vec3(7, 1, 0), Vec3(1, 7, 0));
  const Mesh back = shapes::triangle(Vec3(1, 7, 0), Vec3(7, 1, 0), Vec3(1, 1, 0));
  CHECK(rasterise(front, plain(9, 9)).triangle == rasterise(back, plain(9, 9)).triangle);
  for (const Mesh& mesh : {shapes::triangle(Vec3(1, 1, 0), Vec3(1, 1, 0), Vec3(8, 8, 0)),
                           shapes::triangle(Vec3(1, 1, 0), Vec3(4, 4, 1), Vec3(8, 8, 0)),
                           shapes::triangle(Vec3(4, 4, 0), Vec3(4, 4, 0), Vec3(4, 4, 0))}) {
    CHECK(covered_samples(rasterise(mesh, plain(9, 9))) == 0);
  }
}

TEST_CASE("what is nearer to the viewer is seen, in either order, at the same depth the first") {
  Mesh mesh = shapes::triangle(Vec3(0, 0, 1), Vec3(20, 0, 1), Vec3(0, 20, 1));
  for (const double z : {2.0, 0.0, 2.0}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {Vec3(0, 0, z), Vec3(20, 0, z), Vec3(0, 20, z)});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const Samples samples = rasterise(mesh, plain(8, 8));
  CHECK(covered_samples(samples) == 64);
  CHECK(std::all_of(samples.triangle.begin(), samples.triangle.end(), [](auto t) { return t == 1; }));
  CHECK(samples.depth[0] == doctest::Approx(2));
  const Samples cut = rasterise(mesh, plain(8, 8), 1.5);
  CHECK(std::all_of(cut.triangle.begin(), cut.triangle.end(), [](auto t) { return t == 0; }));
}

TEST_CASE("depth is that of the plane, also across intersecting triangles") {
  Mesh mesh = shapes::triangle(Vec3(0, 0, 0), Vec3(40, 0, 20), Vec3(0, 40, 0));
  mesh.positions.insert(mesh.positions.end(), {Vec3(0, 0, 3), Vec3(40, 0, 3), Vec3(0, 40, 3)});
  mesh.triangles.push_back({3, 4, 5});
  const Samples samples = rasterise(mesh, plain(10, 4));
  for (int x = 0; x < 10; ++x) {
    const double slope = 0.5 * (x + 0.5);
    CAPTURE(x);
    CHECK(samples.triangle[samples.at(x, 2)] == (slope > 3 ? 0 : 1));
    CHECK(samples.depth[samples.at(x, 2)] == doctest::Approx(std::max(slope, 3.0)));
  }
}

TEST_CASE("a surface has no gaps between its triangles") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (int round = 0; round < 20; ++round) {
    Mesh mesh = shapes::grid(23, 40);
    for (Vec3& p : mesh.positions) p += 0.9 * Vec3(shift(random), shift(random), shift(random)) + Vec3(-4, -4, 0);
    CHECK(covered_samples(rasterise(mesh, plain(32, 32))) == 32 * 32);
  }
}

TEST_CASE("triangles that reach far beyond the picture are drawn right") {
  const Mesh mesh = shapes::triangle(Vec3(-1e5, -1e5, 0), Vec3(3e5, -1e5, 0), Vec3(-1e5, 3e5, 0));
  CHECK(covered_samples(rasterise(mesh, plain(64, 48))) == 64 * 48);
  const Mesh beside = shapes::triangle(Vec3(100, 0, 0), Vec3(200, 0, 0), Vec3(100, 90, 0));
  CHECK(covered_samples(rasterise(beside, plain(64, 48))) == 0);
}
