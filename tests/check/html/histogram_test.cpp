#include "check/html/histogram.h"

#include <cmath>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <string>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Histogram of(MeshView mesh, const std::function<double(const Vec3&)>& distance, double limit, std::size_t threads = 1) {
  ThreadPool pool(threads);
  return histogram_of(mesh, distance, limit, 20'000, pool);
}

Axis axis_of(std::initializer_list<double> values) { return axis_for(std::span(values.begin(), values.size())); }

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

TEST_CASE("a linear axis begins at 0 and has room behind the largest value") {
  const Axis axis = axis_of({0, 0.4, 1});
  CHECK_FALSE(axis.logarithmic);
  CHECK(axis.low == 0);
  CHECK(axis.at(0) == 0);
  CHECK(axis.at(0.625) == doctest::Approx(0.5));
  CHECK(axis.at(1) == doctest::Approx(0.8));
}

TEST_CASE("values of several magnitudes get a logarithmic axis on which all of them are apart") {
  const Axis axis = axis_of({1e-6, 0.05, 3});
  CHECK(axis.logarithmic);
  CHECK(axis.at(1e-6) > 0.03);
  CHECK(axis.at(0.05) - axis.at(1e-6) > 0.3);
  CHECK(axis.at(3) - axis.at(0.05) > 0.1);
  CHECK(axis.at(3) < 0.97);
  CHECK(axis.at(0) == 0);
}

TEST_CASE("values close together are shown with their neighbourhood alone") {
  const Axis axis = axis_of({1, 1.01, 1.02});
  CHECK_FALSE(axis.logarithmic);
  CHECK(axis.low > 0.9);
  CHECK(axis.at(1.01) - axis.at(1) > 0.1);
  const Axis with_zero = axis_of({0, 1, 1.01});
  CHECK(with_zero.low == 0);
}

TEST_CASE("an axis maps whatever comes into its length, in order") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-320, 308);
  for (int i = 0; i < 2000; ++i) {
    const double a = std::pow(10, exponent(random)), b = std::pow(10, exponent(random)),
                 c = std::pow(10, exponent(random));
    const Axis axis = axis_of({a, b, c});
    CAPTURE(a);
    CAPTURE(b);
    CAPTURE(c);
    REQUIRE(std::isfinite(axis.low));
    REQUIRE(std::isfinite(axis.high));
    REQUIRE(axis.low < axis.high);
    for (const double x : {a, b, c, 0.0, std::numeric_limits<double>::infinity()}) {
      REQUIRE(axis.at(x) >= 0);
      REQUIRE(axis.at(x) <= 1);
    }
    REQUIRE((a < b ? axis.at(a) <= axis.at(b) : axis.at(b) <= axis.at(a)));
    const auto marks = ticks(axis);
    REQUIRE(marks.size() <= 9);
    for (const AxisTick& mark : marks) REQUIRE(std::isfinite(mark.value));
  }
  CHECK(axis_of({0, 0}).at(std::nan("")) == 0);
}

TEST_CASE("value() is the inverse of at()") {
  for (const Axis& axis : {Axis{false, 2, 5}, Axis{true, 1e-4, 10}}) {
    for (const double share : {0.0, 0.1, 0.5, 0.9}) CHECK(axis.at(axis.value(share)) == doctest::Approx(share));
  }
}

TEST_CASE("ticks are round numbers within the axis, written short") {
  const auto labels = [](const Axis& axis) {
    std::string all;
    for (const AxisTick& tick : ticks(axis)) all += tick.label + " ";
    return all;
  };
  CHECK(labels({false, 0, 1.25}) == "0 0.2 0.4 0.6 0.8 1 1.2 ");
  CHECK(labels({false, 0.93, 1.1}) == "0.95 1 1.05 1.1 ");
  CHECK(labels({true, 0.02, 60}) == "0.1 1 10 ");
  CHECK(labels({true, 0.9, 60}) == "1 2 5 10 20 50 ");
}
