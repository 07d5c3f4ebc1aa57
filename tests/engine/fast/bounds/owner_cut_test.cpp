#include "engine/fast/bounds/owner_cut.h"

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "engine/hausdorff.h"
#include "engine/rounding.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

Piece piece_of(const Bvh& tree, const std::array<Vec3, 3>& corners) {
  Work work;
  Piece piece;
  for (std::size_t i = 0; i < 3; ++i) piece.corners[i] = nearest_corner(tree, corners[i], work);
  return piece;
}

// Two walls of n slices, parallel to the plane x = 0 and equally far from it; turned by `turn`.
Mesh walls(std::uint32_t n, const Eigen::Matrix3d& turn) {
  Mesh mesh;
  for (const double x : {-0.3, 0.3}) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const double y0 = -0.8 + 1.6 * i / n, y1 = -0.8 + 1.6 * (i + 1) / n;
      const auto at = static_cast<std::uint32_t>(mesh.positions.size());
      for (const Vec3& p : {Vec3(x, y0, -0.3), Vec3(x, y1, -0.3), Vec3(x, y1, 0.3), Vec3(x, y0, 0.3)}) {
        mesh.positions.emplace_back(turn * p);
      }
      mesh.triangles.push_back({at, at + 1, at + 2});
      mesh.triangles.push_back({at, at + 2, at + 3});
    }
  }
  return mesh;
}

// The same, each wall one triangle.
Mesh two_triangles(const Eigen::Matrix3d& turn) {
  Mesh mesh;
  for (const double x : {-0.3, 0.3}) {
    for (const Vec3& p : {Vec3(x, -0.6, -0.4), Vec3(x, 0.6, -0.4), Vec3(x, 0, 0.7)})
      mesh.positions.emplace_back(turn * p);
  }
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

Eigen::Matrix3d turned(double angle) {
  return Eigen::AngleAxisd(angle, Vec3(1, 2, -1).normalized()).toRotationMatrix();
}

// Checks that no sample of the piece exceeds the bound, up to R3; the samples include all corners.
void check_samples(const Bvh& tree, const Piece& piece, double upper, std::mt19937_64& random) {
  Work work;
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto& [a, b, c] = piece.corners;
  for (int i = 0; i < 60; ++i) {
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    if (i < 20) v = 0;  // along an edge
    const Vec3 x = (1 - u - v) * a.point + u * b.point + v * c.point;
    REQUIRE(nearest_corner(tree, x, work).distance <= upper + rounding::kDistanceSlack + tree.residual());
  }
}

// How many of random pieces the cut bounds; each bound is at most the limit and holds at samples.
int attack(const Mesh& mesh, std::uint64_t seed, int parts) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5), exponent(-3, 0);
  const Bvh tree = tree_of(mesh);
  int bounded = 0;
  for (int i = 0; i < 2000; ++i) {
    const double size = std::pow(10.0, exponent(random));
    const Vec3 centre(uniform(random), uniform(random), uniform(random));
    const auto corner = [&] { return Vec3(centre + size * Vec3(uniform(random), uniform(random), uniform(random))); };
    const Piece piece = piece_of(tree, {corner(), corner(), corner()});
    Work work;
    OwnerCut cut(piece, tree, work);
    double limit = 0;
    for (const Corner& c : piece.corners) limit = std::max(limit, c.distance);
    limit += std::pow(10.0, 3 * exponent(random));
    const OwnerCut::Attempt attempt = cut.attempt(limit, parts);
    CHECK(work.triangle_tests > 0);
    if (!attempt.upper) continue;
    ++bounded;
    CHECK(*attempt.upper <= limit);
    CHECK(!attempt.too_far);
    check_samples(tree, piece, *attempt.upper, random);
  }
  return bounded;
}

Stop measured(const Mesh& a, const Mesh& b, double tolerance, Outcome& outcome) {
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {tolerance, std::nullopt, std::nullopt};
  Control control;
  outcome = measure(a, b, options, control);
  return outcome.stop;
}

}  // namespace

TEST_CASE("owner cut: a piece across a medial line is bounded by its distance, whatever the direction") {
  for (const double angle : {0.0, 0.4, 1.1, 2.5}) {
    const Eigen::Matrix3d turn = turned(angle);
    const Mesh mesh = two_triangles(turn);
    const Bvh tree = tree_of(mesh);
    const Piece piece =
        piece_of(tree, {turn * Vec3(-0.2, 0.1, 0), turn * Vec3(0.25, 0.15, 0.01), turn * Vec3(0.05, -0.2, 0.02)});
    Work work;
    OwnerCut cut(piece, tree, work);
    const auto attempt = cut.attempt(0.3 + 1e-13, 1);
    REQUIRE(attempt.upper);
    CHECK(*attempt.upper >= 0.3 - 1e-15);
    CHECK(least_farthest(piece, tree, std::array{piece.corners[0].slot, piece.corners[1].slot}, work) > 0.45);
  }
}

TEST_CASE("owner cut: a failed attempt names a point that is too far from the triangles known") {
  const Mesh mesh = two_triangles(turned(0.3));
  const Bvh tree = tree_of(mesh);
  const Piece piece = piece_of(
      tree, {turned(0.3) * Vec3(-0.2, 0, 0), turned(0.3) * Vec3(0.2, 0.1, 0), turned(0.3) * Vec3(0.1, -0.2, 0)});
  Work work;
  OwnerCut cut(piece, tree, work);
  const auto attempt = cut.attempt(0.29, 64);
  REQUIRE(attempt.too_far);
  CHECK(nearest_corner(tree, *attempt.too_far, work).distance == doctest::Approx(0.3));
  CHECK(!attempt.upper);
  CHECK_FALSE(cut.add(piece.corners[0].slot));  // is known
}

TEST_CASE("owner cut: no sample exceeds the bound") {
  std::mt19937_64 random(5);
  const std::array meshes{walls(1, turned(0.7)), walls(7, turned(2)), shapes::scaled(shapes::sphere(12), 0.7),
                          shapes::soup(40, random)};
  for (const Mesh& mesh : meshes) {
    const int whole = attack(mesh, 1, 1), divided = attack(mesh, 1, 64);
    CHECK(whole > 20);
    CHECK(divided >= whole);
  }
}

TEST_CASE("auto: the work along a medial line grows with the logarithm of the tolerance") {
  for (const double angle : {0.0, 0.4, 1.1}) {
    const Eigen::Matrix3d turn = turned(angle);
    for (const std::uint32_t n : {1U, 20U}) {
      const Mesh b = walls(n, turn);
      Mesh a;
      for (const Vec3& p : {Vec3(-0.28, -0.7, 0.02), Vec3(0.27, -0.7, 0), Vec3(0.26, 0.7, 0), Vec3(-0.25, 0.7, 0.01)}) {
        a.positions.emplace_back(turn * p);
      }
      a.triangles = {{0, 1, 2}, {0, 2, 3}};
      Outcome coarse, fine;
      CHECK(measured(a, b, 1e-4, coarse) == Stop::converged);
      CHECK(measured(a, b, 1e-11, fine) == Stop::converged);
      CHECK(fine.lower <= 0.3 + 1e-15);
      CHECK(fine.upper >= 0.3 - 1e-15);
      CHECK(fine.a_to_b->work.triangle_tests < 20 * (200 + coarse.a_to_b->work.triangle_tests));
    }
  }
}
