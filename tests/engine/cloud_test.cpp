// Point clouds: the interval holds the exact distance, and is as narrow as rounding allows whatever the tolerance.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "engine/hausdorff.h"
#include "oracle/exact.h"
#include "shapes.h"
#include "today.h"

using namespace meshgauge;

namespace {

Mesh cloud(std::vector<Vec3> points) {
  Mesh made;
  made.triangles = points_as_triangles(points.size());
  made.positions = std::move(points);
  return made;
}

// Points on and near the corners, edges and triangles of `mesh`, and far from all.
Mesh scan_of(const Mesh& mesh, std::size_t count, double noise, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  std::normal_distribution<double> normal(0, 1);
  const auto off = [&](std::mt19937_64& from) { return noise * normal(from); };
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[random() % mesh.triangles.size()];
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double u = i % 5 == 0 ? 0 : share(random), v = i % 3 == 0 ? 0 : share(random) * (1 - u);
    points.push_back(a + u * (b - a) + v * (c - a) +
                     (i % 2 == 0 ? Vec3(off(random), off(random), off(random)) : Vec3(0, 0, 0)));
  }
  return cloud(std::move(points));
}

Outcome cloud_outcome(const Mesh& a, const Mesh& b, const Options& options) {
  Control control;
  return measure(a, b, options, control);
}

// With each of `all`: the squared distances are found once.
void check_exact(const Mesh& points, const Mesh& mesh, const std::vector<Options>& all) {
  const oracle::Surface surface = oracle::surface_of(mesh);
  std::vector<oracle::Ratio> sq;
  for (const Vec3& p : points.positions) sq.push_back(oracle::distance_sq(oracle::exact(p), surface));
  for (const Options& options : all) {
    const Outcome out = cloud_outcome(points, mesh, options);
    REQUIRE(std::isfinite(out.upper));
    const oracle::Dyadic lower(out.lower), upper(out.upper);
    CHECK(std::ranges::all_of(sq, [&](const oracle::Ratio& one) { return oracle::root_at_most(one, upper); }));
    CHECK(std::ranges::any_of(sq, [&](const oracle::Ratio& one) { return oracle::root_at_least(one, lower); }));
    CHECK(out.upper - out.lower <= 2 * out.precision_floor);
    CHECK((out.stop == Stop::converged || out.stop == Stop::precision_floor));
    REQUIRE(out.a_to_b->bounds.witness);
    CHECK(out.a_to_b->bounds.witness->triangle_a < points.positions.size());
  }
}

Options a_to_b() {
  Options options;
  options.direction = Direction::a_to_b;
  return options;
}

}  // namespace

TEST_CASE("cloud: the interval holds the exact distance, from rounding only") {
  std::mt19937_64 random(5);
  std::uint64_t number = 0;
  for (const double size : {1.0, 1e-150, 1e150, 3e7}) {
    for (const double noise : {0.0, 1e-9, 0.05, 3.0}) {
      if (!is_of_today(number++, 2)) continue;
      CAPTURE(size);
      CAPTURE(noise);
      Mesh mesh = shapes::sphere(8, size);
      const Mesh points = scan_of(mesh, 300, noise * size, random);
      Options loose = a_to_b();
      loose.tolerance = {std::nullopt, std::nullopt, 0.5};
      Options shared = loose;
      shared.threads = 2;
      check_exact(points, mesh, {a_to_b(), loose, shared});
    }
  }
}

TEST_CASE("cloud: one point, repeated points, points on one line, points that are corners") {
  const Mesh mesh = shapes::sphere(6);
  check_exact(cloud({Vec3(1, 2, 3)}), mesh, {a_to_b()});
  check_exact(cloud(std::vector<Vec3>(1000, Vec3(0.1, 0.2, 0.3))), mesh, {a_to_b()});
  std::vector<Vec3> line;
  for (int i = 0; i < 500; ++i) line.emplace_back(0.01 * i, 0, 0);
  check_exact(cloud(std::move(line)), mesh, {a_to_b()});
  check_exact(cloud(mesh.positions), mesh, {a_to_b()});
  CHECK(cloud_outcome(cloud(mesh.positions), mesh, a_to_b()).lower == 0);
}

TEST_CASE("cloud: measured from b, it is as exact") {
  std::mt19937_64 random(6);
  const Mesh mesh = shapes::sphere(8);
  const Mesh points = scan_of(mesh, 300, 0.05, random);
  Options options;
  options.direction = Direction::b_to_a;
  options.tolerance = {std::nullopt, std::nullopt, 0.5};
  const Outcome out = cloud_outcome(mesh, points, options);
  CHECK(out.upper - out.lower <= 2 * out.precision_floor);
}

TEST_CASE("cloud: a gate is decided, and narrowed to the distance itself") {
  std::mt19937_64 random(7);
  const Mesh mesh = shapes::sphere(8);
  const Mesh points = scan_of(mesh, 300, 0.05, random);
  const Outcome exact = cloud_outcome(points, mesh, {a_to_b()});
  for (const double factor : {0.5, 2.0}) {
    Options options = a_to_b();
    options.max_distance = factor * exact.upper;
    options.narrow = true;
    const Outcome out = cloud_outcome(points, mesh, options);
    CHECK((out.lower > *options.max_distance) == (factor < 1));
    CHECK((out.upper <= *options.max_distance) == (factor > 1));
    CHECK(out.upper - out.lower <= 2 * out.precision_floor);
  }
}

TEST_CASE("cloud: only meshes whose triangles are all points are one") {
  CHECK(is_cloud(cloud({Vec3(0, 0, 0), Vec3(1, 0, 0)})));
  CHECK(!is_cloud(shapes::sphere(4)));
  Mesh mixed = cloud({Vec3(0, 0, 0), Vec3(1, 0, 0)});
  mixed.triangles.push_back({0, 0, 1});
  CHECK(!is_cloud(mixed));
}
