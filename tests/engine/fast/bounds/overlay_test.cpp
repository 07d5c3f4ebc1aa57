#include "engine/fast/bounds/overlay.h"

#include <doctest/doctest.h>

#include "engine/rounding.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

// Returns a piece with the nearest triangles of its corners.
Piece piece_of(const Bvh& tree, const Vec3& a, const Vec3& b, const Vec3& c) {
  Work work;
  Piece piece;
  piece.corners = {nearest_corner(tree, a, work), nearest_corner(tree, b, work), nearest_corner(tree, c, work)};
  return piece;
}

std::optional<double> bounded(Overlay& overlay, const Piece& piece, double limit, std::size_t max_visits, Work& work) {
  const auto& [a, b, c] = piece.corners;
  return overlay.attempt(piece, std::array{a.slot, b.slot, c.slot}, limit, max_visits, work).upper;
}

struct Tally {
  int attempts = 0;
  int bounded = 0;
};

// Checks that no sample of the piece exceeds the bound that the overlay gives.
void check_piece(Overlay& overlay, const Bvh& tree, const Piece& piece, double limit, std::mt19937_64& random,
                 Tally& tally) {
  Work work;
  ++tally.attempts;
  const auto upper = bounded(overlay, piece, limit, 64, work);
  if (!upper) return;
  ++tally.bounded;
  CHECK(*upper <= limit);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 60; ++i) {
    double u = uniform(random), v = uniform(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& [a, b, c] = piece.corners;
    const Vec3 x = (1 - u - v) * a.point + u * b.point + v * c.point;
    const double d = nearest_corner(tree, x, work).distance;
    REQUIRE(d <= *upper + rounding::kDistanceSlack + tree.residual());
  }
}

// Tries random pieces close to the mesh, with limits from far too small to generous.
Tally attack(const Mesh& mesh, std::uint64_t seed, int pieces, double height) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const Bvh tree = tree_of(mesh);
  ThreadPool pool(1);
  const Adjacency adjacency(mesh, pool);
  Overlay overlay(tree, adjacency);
  Tally tally;
  for (int i = 0; i < pieces; ++i) {
    const double size = std::pow(10.0, -2 * uniform(random));
    const Vec3 centre(uniform(random), uniform(random), height * (uniform(random) - 0.5));
    const auto corner = [&] {
      return Vec3(centre + size * Vec3(uniform(random) - 0.5, uniform(random) - 0.5, height * (uniform(random) - 0.5)));
    };
    const Piece piece = piece_of(tree, corner(), corner(), corner());
    check_piece(overlay, tree, piece, std::pow(10.0, -3 * uniform(random)), random, tally);
  }
  return tally;
}

// A sheet over the unit square with random heights, some triangles missing, some turned over, some doubled.
Mesh sheet(std::uint32_t n, double height, double missing, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Mesh mesh = shapes::grid(n);
  for (Vec3& p : mesh.positions) p.z() = height * (uniform(random) - 0.5);
  std::vector<Triangle> kept;
  for (Triangle t : mesh.triangles) {
    if (uniform(random) < missing) continue;
    if (uniform(random) < 0.3) std::swap(t[0], t[1]);
    kept.push_back(t);
    if (uniform(random) < 0.05) kept.push_back(t);
  }
  mesh.triangles = kept;
  if (mesh.triangles.empty()) mesh.triangles.push_back({0, 1, n + 1});
  return mesh;
}

// The same sheet with the vertices moved sideways until it folds over itself.
Mesh crumpled(std::uint32_t n, double height, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Mesh mesh = sheet(n, height, 0.05, random);
  for (Vec3& p : mesh.positions) p += Vec3(uniform(random), uniform(random), 0) * (1.5 / n);
  return mesh;
}

}  // namespace

TEST_CASE("overlay: a start that is none is passed over") {
  const Mesh mesh = shapes::grid(4);
  const Bvh tree = tree_of(mesh);
  ThreadPool pool(1);
  const Adjacency adjacency(mesh, pool);
  Overlay overlay(tree, adjacency);
  const Piece piece = piece_of(tree, {0.3, 0.3, 0.1}, {0.7, 0.3, 0.1}, {0.3, 0.7, 0.1});
  Work work;
  const auto none = overlay.attempt(piece, std::array{Nearest::kNone}, 1, 64, work);
  CHECK_FALSE(none.started);
  CHECK_FALSE(none.upper.has_value());
  const auto some = overlay.attempt(piece, std::array{Nearest::kNone, piece.corners[0].slot}, 1, 64, work);
  CHECK(some.started);
  CHECK(some.upper.has_value());
  CHECK_FALSE(overlay.cells(piece, std::array{Nearest::kNone}, 64, work).has_value());
}

TEST_CASE("no sample exceeds the overlay bound: sheets with holes, folds, doubled and turned triangles") {
  std::mt19937_64 random(21);
  Tally all;
  for (int round = 0; round < 60; ++round) {
    for (const std::uint32_t n : {1U, 3U, 8U}) {
      for (const double height : {0.0, 0.01, 0.3}) {
        for (const Mesh& mesh :
             {sheet(n, height, 0.0, random), sheet(n, height, 0.2, random), crumpled(n, height, random)}) {
          const Tally tally = attack(mesh, random(), 40, std::max(height, 0.01));
          all.attempts += tally.attempts;
          all.bounded += tally.bounded;
        }
      }
    }
  }
  CHECK(all.bounded > all.attempts / 10);  // it succeeds often enough to be a test
}

TEST_CASE("no sample exceeds the overlay bound: soups and closed shapes") {
  std::mt19937_64 random(22);
  for (int round = 0; round < 30; ++round) {
    attack(shapes::moved(shapes::scaled(shapes::soup(30, random), 0.5), {0.5, 0.5, 0}), random(), 60, 0.3);
    attack(shapes::sphere(6, 0.4, {0.5, 0.5, 0}), random(), 60, 0.8);
    attack(shapes::cube(0.8, {0.1, 0.1, -0.4}), random(), 60, 0.8);
  }
}

TEST_CASE("overlay: a plane cut into other triangles is bounded by rounding alone, welded or not") {
  for (const bool welded : {true, false}) {
    const Mesh fine = welded ? shapes::grid(5) : shapes::unwelded(shapes::grid(5));
    const Bvh tree = tree_of(fine);
    ThreadPool pool(1);
    const Adjacency adjacency(fine, pool);
    Overlay overlay(tree, adjacency);
    Work work;
    const auto upper = bounded(overlay, piece_of(tree, {0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}), 1e-9, 64, work);
    REQUIRE(upper);
    CHECK(*upper <= rounding::kOverlayGap);
    CHECK_FALSE(
        bounded(overlay, piece_of(tree, {0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}), 1e-9, 10, work));  // too many visits
    CHECK_FALSE(
        bounded(overlay, piece_of(tree, {0, 0, 0}, {1.1, 0, 0}, {0.3, 1, 0}), 1e-9, 64, work));  // over the border
    CHECK_FALSE(
        bounded(overlay, piece_of(tree, {0, 0, 0.1}, {1, 0, 0.1}, {0.3, 1, 0.1}), 0.099, 64, work));  // too high
    CHECK(bounded(overlay, piece_of(tree, {0, 0, 0.1}, {1, 0, 0.1}, {0.3, 1, 0.1}), 0.101, 64, work));
  }
}

TEST_CASE("overlay: a hole under the piece is noticed") {
  Mesh mesh = shapes::grid(9);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Vec3 centre = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3;
    return (centre - Vec3(0.5, 0.5, 0)).norm() < 0.2;
  });
  const Bvh tree = tree_of(mesh);
  ThreadPool pool(1);
  const Adjacency adjacency(mesh, pool);
  Overlay overlay(tree, adjacency);
  Work work;
  const Piece piece = piece_of(tree, {0.05, 0.05, 0}, {0.95, 0.05, 0}, {0.5, 0.95, 0});
  CHECK_FALSE(bounded(overlay, piece, 0.05, 500, work));
  CHECK(bounded(overlay, piece, 0.9, 500, work));
}
