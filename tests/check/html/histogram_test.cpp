#include "check/html/histogram.h"

#include <cmath>
#include <numeric>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Histogram of(MeshView mesh, const std::function<double(const Vec3&)>& distance, double limit, std::size_t threads = 1) {
  ThreadPool pool(threads);
  return histogram_of(mesh, distance, limit, 20'000, pool);
}

}  // namespace

TEST_CASE("shares are shares of the area, whatever the triangles") {
  // A square of which the left half is one piece and the right half a hundred.
  Mesh mesh = shapes::grid(1);
  for (Vec3& p : mesh.positions) p.x() *= 0.5;
  const Mesh fine = shapes::grid(10);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3& p : fine.positions) mesh.positions.emplace_back(0.5 + 0.5 * p.x(), p.y(), 0);
  for (const Triangle& t : fine.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});

  const Histogram histogram = of(
      mesh, [](const Vec3& p) { return p.x(); }, 0.75);
  CHECK(histogram.points == 20'000);
  CHECK(histogram.above_limit == doctest::Approx(0.25).epsilon(0.01));
  CHECK(histogram.median == doctest::Approx(0.5).epsilon(0.01));
  CHECK(histogram.p95 == doctest::Approx(0.95).epsilon(0.01));
  CHECK(histogram.largest <= 1);
  CHECK(std::accumulate(histogram.shares.begin(), histogram.shares.end(), 0.0) == doctest::Approx(1));
  CHECK(histogram.axis.at(histogram.largest) < 1);
}

TEST_CASE("points are spread evenly over a sphere, those of a degenerate triangle are none") {
  const auto points = spread_points(shapes::sphere(40), 10'000);
  CHECK(points.size() == 10'000);
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  for (const Vec3& p : points) sum += p, squares += p.cwiseProduct(p);
  CHECK(sum.norm() / 1e4 < 0.01);
  for (int k = 0; k < 3; ++k) CHECK(squares[k] / 1e4 == doctest::Approx(1.0 / 3).epsilon(0.02));
  CHECK(spread_points(shapes::triangle(Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(2, 2, 2)), 100).empty());
  CHECK(of(
            shapes::triangle(Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)), [](const Vec3&) { return 1.0; }, 1)
            .points == 0);
}

TEST_CASE("a cloud is its points: each of them, or as many as are asked for, from the first to near the last") {
  Mesh cloud = shapes::grid(100);
  cloud.triangles = points_as_triangles(cloud.positions.size());
  const auto x = [](const Vec3& p) { return p.x(); };
  const Histogram all = of(cloud, x, 0.495);
  CHECK(all.of_cloud);
  CHECK(all.points == cloud.positions.size());
  CHECK(all.above_limit == doctest::Approx(51.0 / 101));
  CHECK(all.largest == 1);
  CHECK(spread_points(cloud, 10).size() == 10);
  CHECK(spread_points(cloud, 10).front() == cloud.positions.front());
  CHECK_FALSE(of(shapes::grid(1), x, 1).of_cloud);
}

TEST_CASE("tiny and huge meshes have the same histogram as one of size 1") {
  const auto shares = [](double size) {
    return of(
               shapes::scaled(shapes::sphere(12), size), [](const Vec3& p) { return std::abs(p.z()); }, size)
        .shares;
  };
  CHECK(shares(0x1p-300) == shares(1));
  CHECK(shares(0x1p300) == shares(1));
}

TEST_CASE("distances of many magnitudes get a logarithmic axis, none at all a linear one") {
  const Mesh mesh = shapes::grid(4);
  CHECK(of(
            mesh, [](const Vec3& p) { return std::pow(10, -6 * p.x()); }, 1)
            .axis.logarithmic);
  CHECK_FALSE(of(
                  mesh, [](const Vec3&) { return 0.0; }, 1)
                  .axis.logarithmic);
  CHECK(of(
            mesh, [](const Vec3&) { return 0.0; }, 0)
            .shares.front() == doctest::Approx(1));
}

TEST_CASE("the same bits whatever the size of the pool") {
  const auto distance = [](const Vec3& p) { return p.x() * p.y() + 1; };
  const Histogram one = of(shapes::sphere(9), distance, 1), four = of(shapes::sphere(9), distance, 1, 4);
  CHECK(one.shares == four.shares);
  CHECK(one.above_limit == four.above_limit);
}
