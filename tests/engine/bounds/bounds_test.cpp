// The contract of every strategy's bound: engine/search/piece.h.
#include <doctest/doctest.h>

#include <memory>

#include "engine/paper/four_point.h"
#include "engine/paper/n_point.h"
#include "engine/paper/triangle_set.h"
#include "engine/rounding.h"
#include "patient_search.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

struct Fixture : PatientSearch {
  using PatientSearch::PatientSearch;

  double distance_at(const Piece& p, double u, double v) {
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 x = (1 - u - v) * p.corners[0].point + u * p.corners[1].point + v * p.corners[2].point;
    return nearest_corner(to, x, search.work()).distance;
  }
};

std::vector<std::unique_ptr<PieceBound>> all_bounds(Fixture& f) {
  std::vector<std::unique_ptr<PieceBound>> bounds;
  bounds.push_back(std::make_unique<FourPoint>(f.to, f.search.work()));
  for (const int level : {0, 1, 2, 3}) bounds.push_back(std::make_unique<NPoint>(f.to, level, f.search.work()));
  bounds.push_back(std::make_unique<TriangleSet>(f.search));
  return bounds;
}

}  // namespace

TEST_CASE("no sample of a piece exceeds any strategy's bound, and more candidates never loosen it") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int round = 0; round < 60; ++round) {
    Fixture f(shapes::scaled(shapes::soup(4, random), round % 2 ? 0.5 : 0.05),
              round % 3 ? shapes::soup(30, random) : shapes::sphere(6, 0.5));
    const auto bounds = all_bounds(f);
    for (std::uint32_t t = 0; t < 4; ++t) {
      const Piece piece = f.piece(t);
      std::vector<double> uppers;
      for (const auto& bound : bounds) uppers.push_back(bound->upper(piece));
      CHECK(uppers[0] == uppers[1]);  // four_point is n_point with 4
      for (const double upper : uppers)
        CHECK(uppers.back() <= upper + rounding::kDistanceSlack);  // triangle_set has every candidate
      for (int i = 0; i < 50; ++i) {
        const double d = f.distance_at(piece, uniform(random), uniform(random));
        for (const double upper : uppers) CHECK(d <= upper + rounding::kDistanceSlack + f.to.residual());
      }
    }
  }
}

TEST_CASE("triangle_set finds the nearest triangle of every point of its piece without a query") {
  std::mt19937_64 random(12);
  for (int round = 0; round < 40; ++round) {
    Fixture f(shapes::scaled(shapes::soup(2, random), 0.3), shapes::soup(40, random));
    TriangleSet set(f.search);
    const Piece piece = f.piece(0);
    set.upper(piece);
    const std::uint64_t queries = f.search.work().nearest_queries;
    Work other;
    for (const auto& [u, v] : {std::pair(0.5, 0.5), std::pair(0.5, 0.0), std::pair(0.2, 0.3), std::pair(0.9, 0.05)}) {
      const Vec3 x = (1 - u - v) * piece.corners[0].point + u * piece.corners[1].point + v * piece.corners[2].point;
      CHECK(set.measure(x, piece).distance == nearest_corner(f.to, x, other).distance);
    }
    CHECK(f.search.work().nearest_queries == queries);
    CHECK(set.memory_bytes() > 0);
  }
}

TEST_CASE("four_point queries a point of a subdivision once for the two parts beside it") {
  std::mt19937_64 random(13);
  Fixture f(shapes::scaled(shapes::soup(2, random), 0.3), shapes::soup(40, random));
  Work work;
  FourPoint bound(f.to, work);
  const Piece piece = f.piece(0);
  const Vec3 p = (piece.corners[0].point + piece.corners[1].point) * 0.5;
  const Corner first = bound.measure(p, piece);
  CHECK(bound.memory_bytes() > 0);
  const Corner second = bound.measure(p, piece);
  CHECK(first.distance == second.distance);
  CHECK(first.slot == second.slot);
  CHECK(work.nearest_queries == 1);
  CHECK(work.cache_hits == 1);
  CHECK(bound.memory_bytes() == 0);  // an edge has two sides
  CHECK(bound.measure(p, piece).distance == first.distance);
  CHECK(work.nearest_queries == 2);
}

TEST_CASE("the stencils of Figure 1") {
  for (const int points : {4, 10, 31, 109, 409, 1585}) CHECK(is_stencil(points));
  for (const int points : {-1, 0, 3, 5, 11, 1584}) CHECK_FALSE(is_stencil(points));
  CHECK(stencil_level(1585) == 5);

  Fixture f(shapes::triangle({0, 0, 1}, {1, 0, 1}, {0, 1, 1}), shapes::grid(3));
  const Piece piece = f.piece(0);
  for (const auto& [points, level] : {std::pair(4, 0), std::pair(10, 1), std::pair(31, 2), std::pair(1585, 5)}) {
    NPoint bound(f.to, level, f.search.work());
    const std::uint64_t before = f.search.work().nearest_queries;
    (void)bound.upper(piece);
    CHECK(f.search.work().nearest_queries - before == static_cast<std::uint64_t>(points - 3));
  }
}
