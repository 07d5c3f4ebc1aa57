// Alignment finds displaced copies, is the same on any number of threads, and says nothing when it is interrupted.
#include "engine/extras/align/align.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "engine/hausdorff.h"
#include "shapes.h"
#include "today.h"

using namespace meshgauge;

namespace {

// A sphere with bumps that no rotation maps to each other.
Mesh bumpy(std::uint32_t rings = 24) {
  Mesh mesh = shapes::sphere(rings);
  for (Vec3& p : mesh.positions) {
    const double bumps = 0.3 * std::sin(3 * p.x() + 1) * std::cos(2 * p.y()) + 0.2 * std::sin(4 * p.z() + p.x());
    p = Vec3(1.3, 1, 0.8).cwiseProduct(p * (1 + bumps));
  }
  return mesh;
}

struct PoseDice {
  std::mt19937_64 bits;

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(bits); }
  double normal() { return std::normal_distribution<double>()(bits); }
  Vec3 direction() { return Vec3(normal(), normal(), normal()).normalized(); }
};

// About the centre, by up to 30 degrees, and by up to 10 % of the diagonal.
RigidMotion displacement_of(const Mesh& mesh, PoseDice& dice) {
  const Box box = bounding_box(mesh);
  const Vec3 centre = (box.low + box.high) / 2;
  const RigidMotion::Matrix turn = Eigen::AngleAxisd(dice.uniform(0, 0.5236), dice.direction()).toRotationMatrix();
  return {turn, centre - turn * centre + dice.uniform(0, 0.1) * diagonal(box) * dice.direction()};
}

Mesh moved_by(Mesh mesh, const RigidMotion& motion) {
  for (Vec3& p : mesh.positions) p = motion(p);
  return mesh;
}

std::optional<Alignment> aligned(const Mesh& a, const Mesh& b, const AlignOptions& options = {}, unsigned threads = 1,
                                 std::string_view simd = "auto") {
  Control control;
  return align(Prepared(a), Prepared(b), options, threads, simd, control);
}

}  // namespace

TEST_CASE("align: displaced copies are found, exact, with noise, in part and as points") {
  PoseDice dice{std::mt19937_64(1)};
  const Mesh fixed = bumpy();
  const double size = diagonal(fixed);
  for (unsigned i = 0; i < 40; ++i) {
    CAPTURE(i);
    const RigidMotion away = displacement_of(fixed, dice);
    Mesh copy = fixed;
    if (i % 2 == 1) {
      for (Vec3& p : copy.positions) p += 0.002 * size * Vec3(dice.normal(), dice.normal(), dice.normal());
    }
    if (i % 4 >= 2) copy.triangles.resize(copy.triangles.size() * 3 / 5);
    if (i % 5 == 0) copy.triangles = points_as_triangles(copy.positions.size());
    if (!is_of_today(i / 4, 4)) continue;
    copy = moved_by(copy, away);
    const auto found = aligned(copy, fixed), known = aligned(copy, fixed, {away.inverse()});
    REQUIRE(found);
    CHECK(found->converged);
    CHECK(found->residual <= std::max(1.01 * known->residual, 1e-10 * size));
    CHECK(found->before >= found->residual);
    CHECK(off_orthonormal(found->motion.rotation) < RigidMotion::kOrthonormal);
    if (i % 2 == 0) CHECK((found->motion(away(Vec3(1, 0, 0))) - Vec3(1, 0, 0)).norm() < 1e-9);
  }
}

TEST_CASE("align: what the fixed mesh lacks does not count with an overlap") {
  PoseDice dice{std::mt19937_64(2)};
  Mesh fixed = bumpy();
  const RigidMotion away = displacement_of(fixed, dice);
  const Mesh copy = moved_by(fixed, away);
  fixed.triangles.resize(fixed.triangles.size() * 4 / 5);
  const auto all = aligned(copy, fixed), most = aligned(copy, fixed, {{}, true, false, 0.7});
  REQUIRE(all);
  REQUIRE(most);
  CHECK(all->residual > 1e-3);
  CHECK(most->residual < 1e-9);
}

TEST_CASE("align: from the principal axes any displacement is found") {
  PoseDice dice{std::mt19937_64(3)};
  const Mesh fixed = bumpy();
  for (int i = 0; i < 4; ++i) {
    const RigidMotion away{Eigen::AngleAxisd(dice.uniform(2, 3), dice.direction()).toRotationMatrix(),
                           100 * dice.direction()};
    const auto found = aligned(moved_by(fixed, away), fixed, {{}, true, true});
    REQUIRE(found);
    CHECK(found->residual < 1e-9);
    CHECK(found->starts > 24);
  }
}

TEST_CASE("align: a motion that is given is the answer, or the start") {
  const Mesh fixed = bumpy();
  const RigidMotion away{Eigen::AngleAxisd(3, Vec3::UnitX()).toRotationMatrix(), Vec3(50, 0, 0)};
  const Mesh copy = moved_by(fixed, away);
  RigidMotion near = away.inverse();
  near.translation.x() += 0.1;
  const auto given = aligned(copy, fixed, {near, false});
  REQUIRE(given);
  CHECK(given->motion == near);
  CHECK(given->starts == 0);
  CHECK(given->residual == given->before);
  CHECK(given->residual > 0.01);
  CHECK(aligned(copy, fixed, {near})->residual < 1e-9);
}

TEST_CASE("align: what lies in place is not moved") {
  const Mesh fixed = bumpy();
  const auto found = aligned(fixed, fixed);
  REQUIRE(found);
  CHECK(found->motion.is_identity());
  CHECK(found->residual < 1e-14);
}

TEST_CASE("align: where the fixed mesh is a cloud, its points are the samples") {
  PoseDice dice{std::mt19937_64(5)};
  const Mesh mesh = bumpy();
  Mesh cloud = mesh;
  cloud.triangles = points_as_triangles(cloud.positions.size());
  const RigidMotion away = displacement_of(mesh, dice);
  const auto found = aligned(moved_by(mesh, away), cloud);
  REQUIRE(found);
  CHECK(found->residual < 1e-9);
  CHECK((found->motion(away(Vec3(1, 2, 3))) - Vec3(1, 2, 3)).norm() < 1e-8);
  CHECK(aligned(mesh, cloud, {away, false})->motion == away);
}

TEST_CASE("align: the bits depend on neither threads nor instruction set") {
  PoseDice dice{std::mt19937_64(6)};
  const Mesh fixed = bumpy();
  const Mesh copy = moved_by(bumpy(17), displacement_of(fixed, dice));
  const auto one = aligned(copy, fixed);
  REQUIRE(one);
  for (const std::string_view simd : supported_simd()) {
    for (const unsigned threads : {1U, 3U}) {
      const auto other = aligned(copy, fixed, {}, threads, simd);
      REQUIRE(other);
      CHECK(other->motion == one->motion);
      CHECK(other->residual == one->residual);
      CHECK(other->steps == one->steps);
    }
  }
}

TEST_CASE("align: an interruption gives no half answer") {
  const Mesh fixed = bumpy(8);
  const Mesh copy = moved_by(fixed, {RigidMotion::Matrix::Identity(), Vec3(0.3, 0.1, 0)});
  Control whole;
  REQUIRE(align(Prepared(copy), Prepared(fixed), {}, 1, "auto", whole));
  for (std::uint64_t n = 1; n < whole.checks(); n += 1 + whole.checks() / 50) {
    Control control;
    control.cancel_at_check(n);
    CHECK_FALSE(align(Prepared(copy), Prepared(fixed), {}, 2, "auto", control));
    CHECK(control.checks() < n + 100);
  }
}

TEST_CASE("align: any pair ends with finite numbers") {
  const Mesh fixed = bumpy(6);
  const Mesh point{{{1, 2, 3}}, {{0, 0, 0}}};
  const Mesh segment{{{0, 0, 0}, {1, 1, 1}}, {{0, 1, 1}}};
  const std::vector<Mesh> all{fixed,
                              point,
                              segment,
                              shapes::grid(3),
                              shapes::sphere(5),
                              shapes::scaled(fixed, 1e-300),
                              shapes::scaled(fixed, 0x1p1015),
                              shapes::scaled(fixed, 5e-324),
                              shapes::moved(fixed, Vec3(1e15, 0, 0))};
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < all.size(); ++j) {
      if (!is_of_today(i + j, all.size())) continue;
      CAPTURE(i);
      CAPTURE(j);
      const auto found = aligned(all[i], all[j], {{}, true, true});
      REQUIRE(found);
      CHECK(std::isfinite(found->residual));
      CHECK(found->residual <= found->before);
      CHECK(found->motion.translation.allFinite());
      CHECK(off_orthonormal(found->motion.rotation) < RigidMotion::kOrthonormal);
    }
  }
}
