#include "tests/engine/bounds/tightness.h"

#include <doctest/doctest.h>

#include "engine/bounds/four_point.h"
#include "engine/bounds/n_point.h"
#include "engine/bounds/triangle_set.h"
#include "patient_search.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

struct Measured : PatientSearch {
  using PatientSearch::PatientSearch;

  double of(PieceBound&& bound, const Piece& p) { return tightness(best_upper(p, to), bound.upper(p), to); }
  double of_four_point(const Piece& p) { return of(FourPoint(to, search.work()), p); }
  double of_n_point(int points, const Piece& p) {
    return of(NPoint(to, stencil_level(points).value(), search.work()), p);
  }
  double of_triangle_set(const Piece& p) { return of(TriangleSet(search), p); }
};

// Adds a triangle that stands on its tip: the tip is its nearest point for every point above the tip.
void add_spike(Mesh& mesh, const Vec3& tip) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {tip, tip + Vec3(0.01, 0, -1), tip + Vec3(0, 0.01, -1)});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// A lid 1/4 above the triangle (0,0) (1,0) (0,1), and a spike 1/8 below each of its four points.
Measured lid_and_spikes() {
  Mesh b = shapes::triangle({-1, -1, 0.25}, {3, -1, 0.25}, {-1, 3, 0.25});
  for (const auto& [x, y] :
       {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(0.0, 1.0), std::pair(1 / 3.0, 1 / 3.0)})
    add_spike(b, {x, y, -0.125});
  return {shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), std::move(b)};
}

}  // namespace

TEST_CASE("tightness of a constructed pair: the spikes hide the lid from four points, not from ten") {
  Measured f = lid_and_spikes();
  const Piece piece = f.piece();
  CHECK(best_upper(piece, f.to) == doctest::Approx(0.25).epsilon(1e-14));
  // The best candidate of the four points is the spike of the centroid, sqrt(5)/3 from the farther corners.
  const double four = std::sqrt(5.0 / 9 + 1.0 / 64);
  CHECK(FourPoint(f.to, f.search.work()).upper(piece) == doctest::Approx(four).epsilon(1e-14));
  CHECK(f.of_four_point(piece) == doctest::Approx(0.25 / four).epsilon(1e-14));
  CHECK(f.of_n_point(4, piece) == f.of_four_point(piece));
  CHECK(f.of_n_point(10, piece) == 1);
  CHECK(f.of_triangle_set(piece) == 1);
}

TEST_CASE("best_upper is the minimum over all triangles by brute force") {
  std::mt19937_64 random(21);
  for (int round = 0; round < 30; ++round) {
    Measured f(shapes::scaled(shapes::soup(2, random), 0.4), shapes::soup(50, random));
    const Piece piece = f.piece(1);
    const MeshView b = f.b;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < 50; ++t) {
      const PreparedTriangle triangle = prepare(b.corner(t, 0), b.corner(t, 1), b.corner(t, 2)).triangle;
      double farthest = 0;
      for (const Corner& corner : piece.corners) farthest = std::max(farthest, distance(triangle, corner.point));
      least = std::min(least, farthest);
    }
    CHECK(best_upper(piece, f.to) == doctest::Approx(least).epsilon(1e-14));
  }
}

TEST_CASE("tightness is in 0 to 1, never falls from stencil to stencil, and is 1 for triangle_set") {
  std::mt19937_64 random(22);
  int loose = 0, gained = 0;
  for (int round = 0; round < 80; ++round) {
    Measured f(shapes::scaled(shapes::soup(4, random), round % 2 ? 0.5 : 0.05), shapes::soup(60, random));
    for (std::uint32_t t = 0; t < 4; ++t) {
      const Piece piece = f.piece(t);
      CHECK(f.of_triangle_set(piece) == 1);
      double before = f.of_four_point(piece);
      CHECK(before > 0);
      loose += before < 1;
      for (const int points : {4, 10, 31, 109, 409}) {
        const double ratio = f.of_n_point(points, piece);
        CHECK(ratio >= before);
        CHECK(ratio <= 1);
        gained += ratio > before;
        before = ratio;
      }
    }
  }
  CHECK(loose > 30);
  CHECK(gained > 30);
}

TEST_CASE("tightness on a closed surface, where triangles share the points nearest to samples") {
  std::mt19937_64 random(23);
  Measured f(shapes::scaled(shapes::soup(200, random), 0.5), shapes::sphere(8, 0.5));
  std::array<double, 4> sums{};
  for (std::uint32_t t = 0; t < 200; ++t) {
    const Piece piece = f.piece(t);
    CHECK(f.of_triangle_set(piece) == 1);
    for (std::size_t level = 0; level < sums.size(); ++level) {
      const double ratio = f.of_n_point(std::array{4, 10, 31, 109}[level], piece);
      CHECK(ratio > 0);
      CHECK(ratio <= 1);
      sums[level] += ratio;
    }
  }
  CHECK(std::is_sorted(sums.begin(), sums.end()));
  CHECK(sums.front() < 199);
}

TEST_CASE("tightness is 1 for a bound within rounding of 0") {
  Measured same(shapes::sphere(6), shapes::sphere(6));
  for (std::uint32_t t = 0; t < same.a.triangles.size(); ++t) {
    const Piece piece = same.piece(t);
    CHECK(same.of_four_point(piece) == 1);
    CHECK(same.of_triangle_set(piece) == 1);
  }
  CHECK(tightness(0, 0, same.to) == 1);
  CHECK(tightness(0, 0x1p-51, same.to) == 1);
  CHECK(tightness(0, 0.5, same.to) == 0);
}
