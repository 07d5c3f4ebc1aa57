// Rigid motion against exact arithmetic: the stored matrix applied to the stored coordinates.
#include "engine/mesh/rigid.h"

#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "engine/extras/align/align.h"
#include "engine/hausdorff.h"
#include "engine/tree/prepared.h"
#include "oracle/farthest.h"
#include "shapes.h"
#include "today.h"

using namespace meshgauge;
using oracle::Dyadic;
using oracle::Point;

namespace {

RigidMotion random_motion(std::mt19937_64& bits, double shift) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Quaterniond turn(unit(bits), unit(bits), unit(bits), unit(bits));
  return {turn.normalized().toRotationMatrix(), shift * Vec3(unit(bits), unit(bits), unit(bits))};
}

// A quarter turn about z.
RigidMotion quarter_turn(const Vec3& translation) {
  RigidMotion motion;
  motion.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  motion.translation = translation;
  return motion;
}

// The image of p, which is `times` as long as in the unit of the motion.
Point exactly_moved(const Point& p, const RigidMotion& motion, double times = 1) {
  const auto row = [&](int k) {
    return oracle::dot(oracle::exact(motion.rotation.row(k)), p) + Dyadic(times) * Dyadic(motion.translation[k]);
  };
  return {row(0), row(1), row(2)};
}

oracle::Surface exactly_moved(oracle::Surface surface, const RigidMotion& motion, double times) {
  for (auto& triangle : surface) {
    for (Point& corner : triangle) corner = exactly_moved(corner, motion, times);
  }
  return surface;
}

Mesh some_triangles(std::mt19937_64& bits, double size, double offset) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Mesh mesh;
  for (int i = 0; i < 5; ++i)
    mesh.positions.emplace_back(offset + size * unit(bits), offset + size * unit(bits), size * unit(bits));
  for (std::uint32_t i = 0; i < 3; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  return mesh;
}

Options without_tolerance() {
  Options options;
  options.tolerance = {0, std::nullopt, std::nullopt};
  options.max_work_items = 2000;
  return options;
}

}  // namespace

TEST_CASE("rigid: no position is farther from its exact image than the error") {
  std::mt19937_64 bits(25);
  for (const double size : {1.0, 1e-310, 5e-324, 1e-160, 1e150, 1e300}) {
    for (int i = 0; i < 100; ++i) {
      const Mesh mesh = some_triangles(bits, size, i % 3 == 0 ? 1e6 * size : 0);
      const RigidMotion motion = random_motion(bits, i % 2 == 0 ? size : 1e3);
      const auto image = moved(mesh, motion);
      REQUIRE(image);
      for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Point off = oracle::exact(image->positions[v]) - exactly_moved(oracle::exact(mesh.positions[v]), motion);
        CHECK(oracle::dot(off, off) <= Dyadic(image->error) * Dyadic(image->error));
      }
    }
  }
}

TEST_CASE("rigid: the error is a rounding of the result, not of what cancels on the way") {
  std::mt19937_64 bits(26);
  const Mesh mesh = some_triangles(bits, 1, 1e6);
  RigidMotion motion = random_motion(bits, 0);
  motion.translation = -(motion.rotation * Vec3(1e6, 1e6, 0));
  const auto image = moved(mesh, motion);
  REQUIRE(image);
  CHECK(image->error > 0);
  CHECK(image->error <= 4 * 0x1p-53);
}

TEST_CASE("rigid: exact motions have no error") {
  const Mesh mesh = shapes::cube(3);
  for (const RigidMotion& motion : {RigidMotion(), quarter_turn({4, -8, 1024})}) {
    const auto image = moved(mesh, motion);
    REQUIRE(image);
    CHECK(image->error == 0);
    CHECK(image->positions[7] == motion(mesh.positions[7]));
  }
  CHECK(moved(mesh, quarter_turn({0.1, 0, 0}))->error > 0);
  CHECK(moved(mesh, RigidMotion(), 0.5)->error >= 0.5);
}

TEST_CASE("rigid: the interval holds for the exact image, with an error of before") {
  std::mt19937_64 bits(27);
  for (const double size : {1.0, 1e-300, 1e3}) {
    for (int i = 0; i < 60; ++i) {
      const Mesh mesh = some_triangles(bits, size, i % 3 == 0 ? 100 * size : 0), b = some_triangles(bits, size, 0);
      const RigidMotion motion = random_motion(bits, size);
      const Factor factor = i % 2 == 0 ? Factor{1, 1} : Factor{127, 5};
      const auto in_unit = scaled(mesh, factor);
      REQUIRE(in_unit);
      const auto image = moved({in_unit->positions, mesh.triangles}, motion, factor.is_one() ? 0 : in_unit->error);
      REQUIRE(image);
      const Prepared of_a({image->positions, mesh.triangles}, Prepared::Use::once, nullptr, std::nullopt, image->error);
      Control control;
      const Outcome outcome = measure(of_a, Prepared(b), without_tolerance(), control);
      // Both surfaces times `over`, which avoids the quotient.
      const auto from = exactly_moved(oracle::times(oracle::surface_of(mesh), factor.times), motion, factor.over);
      const auto to = oracle::times(oracle::surface_of(b), factor.over);
      const Dyadic times = factor.over;
      const auto check = [&](const Bounds& bounds, const oracle::Bracket& exact) {
        CHECK(oracle::root_at_most(exact.lower_sq, times * Dyadic(bounds.upper)));
        CHECK(oracle::root_at_least(exact.upper_sq, times * Dyadic(bounds.lower)));
      };
      check(outcome.a_to_b->bounds, oracle::exact_bracket(from, to, 200));
      check(outcome.b_to_a->bounds, oracle::exact_bracket(to, from, 200));
      CHECK(outcome.precision_floor >= 2 * image->error);
    }
  }
}

TEST_CASE("rigid: the interval holds for the exact image by a motion that alignment found") {
  std::mt19937_64 bits(28);
  for (unsigned i = 0; i < 10; ++i) {
    const Mesh a = some_triangles(bits, 1, i % 2 == 0 ? 1e3 : 0), b = some_triangles(bits, 1, 0);
    if (!is_of_today(i, 3)) continue;
    Control control;
    const auto found = align(Prepared(a), Prepared(b), {{}, true, true}, 1, "auto", control);
    REQUIRE(found);
    const auto image = moved(a, found->motion);
    REQUIRE(image);
    const Prepared of_a({image->positions, a.triangles}, Prepared::Use::once, nullptr, std::nullopt, image->error);
    const Outcome outcome = measure(of_a, Prepared(b), without_tolerance(), control);
    const auto exact =
        oracle::exact_bracket(exactly_moved(oracle::surface_of(a), found->motion, 1), oracle::surface_of(b), 200);
    CHECK(oracle::root_at_most(exact.lower_sq, Dyadic(outcome.a_to_b->bounds.upper)));
    CHECK(oracle::root_at_least(exact.upper_sq, Dyadic(outcome.a_to_b->bounds.lower)));
  }
}

TEST_CASE("rigid: a vertex that no triangle uses is moved, too, and does not count for the error") {
  Mesh mesh = shapes::cube(1);
  const auto bound = [&](const RigidMotion& motion) { return moved(mesh, motion, 0, never_interrupted).value(); };
  std::mt19937_64 bits(5);
  const RigidMotion motion = random_motion(bits, 3);
  const double error = bound(motion).error;
  mesh.positions.push_back({1e150, 2e150, -3e150});
  mesh.positions.push_back({1, 2, 3});
  const RoundedImage image = bound(motion);
  CHECK(image.error == error);
  CHECK((image.positions.back() - motion(Vec3(1, 2, 3))).norm() < 1e-12);
  CHECK(std::isfinite(image.positions[mesh.positions.size() - 2].sum()));
}

TEST_CASE("rigid: a coordinate out of range and an interruption give nothing") {
  const Mesh mesh = shapes::cube(1, Vec3(0x1p1019, 0, 0));
  CHECK(moved(mesh, {}));
  RigidMotion away;
  away.translation = Vec3(0x1p1020, 0, 0);
  CHECK_FALSE(moved(mesh, away));
  const Mesh many = shapes::grid(100);
  CHECK_FALSE(moved(many, {}, 0, [] { return true; }));
  CHECK_FALSE(displacement(many, bounding_box(many), {}, [] { return true; }));
}

TEST_CASE("rigid: the nearest rotation mends what six decimals leave, and how far a motion goes is told") {
  RigidMotion::Matrix written;
  written << 0.866025, -0.5, 0, 0.5, 0.866025, 0, 0, 0, 1;
  CHECK(off_orthonormal(written) > 1e-7);
  const RigidMotion::Matrix mended = nearest_rotation(written);
  CHECK(off_orthonormal(mended) < RigidMotion::kOrthonormal);
  CHECK((mended - written).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(mended.determinant() > 0);
  CHECK(std::isnan(off_orthonormal(RigidMotion::Matrix::Constant(std::numeric_limits<double>::quiet_NaN()))));

  const Mesh mesh = shapes::cube(2, Vec3(-1, -1, -1));
  const auto found = displacement(mesh, bounding_box(mesh), {mended, Vec3(0, 0, 4)});
  REQUIRE(found);
  CHECK(found->angle == doctest::Approx(30));
  CHECK(found->shift == doctest::Approx(4));
  CHECK(found->largest > 4);
  CHECK(found->largest < 4.2);
}
