#include "engine/extras/statistics/surface_sampler.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "shapes.h"

using namespace meshgauge;

namespace {

SurfaceSampler sampler_of(const Mesh& mesh, std::size_t strata) {
  Control control;
  return {mesh, strata, control};
}

// Returns one point of each stratum.
std::vector<Vec3> points_of(const Mesh& mesh, std::size_t strata) {
  const SurfaceSampler sampler = sampler_of(mesh, strata);
  std::mt19937_64 random(1);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < strata; ++i) points.push_back(sampler.point(i, random));
  return points;
}

// Returns the barycentric coordinates of a point in a triangle, both in the plane z = 0.
Vec3 weights_in(MeshView mesh, std::size_t t, const Vec3& p) {
  const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
  const double all = (b - a).cross(c - a).z();
  return {(b - p).cross(c - p).z() / all, (c - p).cross(a - p).z() / all, (a - p).cross(b - p).z() / all};
}

bool holds(MeshView mesh, std::size_t t, const Vec3& p) { return weights_in(mesh, t, p).minCoeff() >= -1e-12; }

}  // namespace

TEST_CASE("sampler: each triangle gets points in proportion to its area") {
  // Areas 1, 3 and 0.
  const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 0.5, 0}, {0, -1.5, 0}, {-1, 0, 0}}, {{0, 1, 2}, {0, 3, 1}, {0, 1, 4}}};
  CHECK(sampler_of(mesh, 10).weight() == Weight::area);
  const auto points = points_of(mesh, 4000);
  std::size_t small = 0;
  for (const Vec3& p : points) {
    REQUIRE((holds(mesh, 0, p) || holds(mesh, 1, p)));
    small += p.y() > 0 ? 1U : 0U;
  }
  CHECK(small == 1000);  // strata end where the triangle does
}

TEST_CASE("sampler: the points of a triangle are uniform, whichever edge is the longest") {
  const std::vector<Vec3> corners{{0, 0, 0}, {0.9, 0.1, 0}, {0.2, 0.3, 0}};
  for (const Triangle& order : {Triangle{0, 1, 2}, Triangle{1, 2, 0}, Triangle{2, 0, 1}, Triangle{2, 1, 0}}) {
    const Mesh mesh{corners, {order}};
    constexpr std::size_t kPoints = 20'000;
    // A uniform point has weights of mean 1/3, of mean square 1/6 and of mean product 1/12.
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : points_of(mesh, kPoints)) {
      REQUIRE(holds(mesh, 0, p));
      const Vec3 w = weights_in(mesh, 0, p);
      sum += w / kPoints;
      products += w * w.transpose() / kPoints;
    }
    for (int i = 0; i < 3; ++i) {
      CHECK(sum[i] == doctest::Approx(1.0 / 3).epsilon(1e-3));
      for (int j = 0; j < 3; ++j) CHECK(products(i, j) == doctest::Approx(i == j ? 1.0 / 6 : 1.0 / 12).epsilon(1e-3));
    }
  }
}

TEST_CASE("sampler: a stratum is a compact patch") {
  const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const SurfaceSampler sampler = sampler_of(mesh, 1024);
  std::mt19937_64 random(1);
  for (std::size_t stratum = 0; stratum < sampler.strata(); ++stratum) {
    const Vec3 first = sampler.point(stratum, random);
    for (int i = 0; i < 10; ++i) {
      CHECK((sampler.point(stratum, random) - first).norm() < 4.0 / 32);  // a square of this area is 1/32 wide
    }
  }
}

TEST_CASE("sampler: the seed determines the points") {
  const Mesh mesh = shapes::sphere(4, 0.5);
  const SurfaceSampler sampler = sampler_of(mesh, 8);
  std::mt19937_64 one(1), again(1), two(2);
  const Vec3 p = sampler.point(3, one);
  CHECK(p == sampler.point(3, again));
  CHECK(p != sampler.point(3, two));
}

TEST_CASE("sampler: without area it samples segments by length, without length points") {
  // Collinear triangles, 0.6 and 0.2 long, and a point.
  const Mesh segments{{{0, 0, 0}, {0.6, 0, 0}, {0.3, 0, 0}, {0, 0.5, 0}, {0, 0.5, 0.2}},
                      {{0, 2, 1}, {3, 4, 3}, {3, 3, 3}}};
  CHECK(sampler_of(segments, 10).weight() == Weight::length);
  std::size_t on_first = 0;
  for (const Vec3& p : points_of(segments, 400)) {
    const bool first = p.y() == 0;
    REQUIRE((first ? p.x() >= 0 && p.x() <= 0.6 && p.z() == 0 : p.x() == 0 && p.y() == 0.5 && p.z() <= 0.2));
    on_first += first ? 1U : 0U;
  }
  CHECK(on_first == 300);

  const Mesh points{{{0.1, 0, 0}, {0.2, 0, 0}}, {{0, 0, 0}, {1, 1, 1}}};
  CHECK(sampler_of(points, 10).weight() == Weight::points);
  const auto drawn = points_of(points, 10);
  CHECK(std::count(drawn.begin(), drawn.end(), Vec3(0.1, 0, 0)) == 5);
  CHECK(std::count(drawn.begin(), drawn.end(), Vec3(0.2, 0, 0)) == 5);
}
