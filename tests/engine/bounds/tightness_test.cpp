#include "tests/engine/bounds/tightness.h"

#include <doctest/doctest.h>

#include "engine/paper/four_point.h"
#include "engine/paper/n_point.h"
#include "engine/paper/triangle_set.h"
#include "patient_search.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

struct Measured : PatientSearch {
  using PatientSearch::PatientSearch;

  double four_point(const Piece& p) { return FourPoint(to, search.work()).upper(p); }
  double n_point(int points, const Piece& p) {
    return NPoint(to, stencil_level(points).value(), search.work()).upper(p);
  }
  double triangle_set(const Piece& p) { return TriangleSet(search).upper(p); }
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
  const double h = distance_by_subdivision(f.a, 0, f.b);
  CHECK(h == doctest::Approx(0.25).epsilon(1e-8));  // between two spikes the lid is nearest
  // The best candidate of the four points is the spike of the centroid, sqrt(5)/3 from the farther corners.
  const double four = std::sqrt(5.0 / 9 + 1.0 / 64);
  CHECK(f.four_point(piece) == doctest::Approx(four).epsilon(1e-14));
  CHECK(tightness(f.four_point(piece), h) == doctest::Approx(four / 0.25 - 1).epsilon(1e-7));
  CHECK(f.n_point(4, piece) == f.four_point(piece));
  CHECK(std::abs(tightness(f.n_point(10, piece), h)) < 1e-7);
  CHECK(std::abs(tightness(f.triangle_set(piece), h)) < 1e-7);
}

TEST_CASE("the distance by subdivision is that of the best triangle of B where there is one, and of the vertices") {
  const Mesh b = shapes::triangle({-9, -9, 0}, {9, -9, 0}, {0, 9, 0});
  Mesh a = shapes::triangle({0, 0, 0.1}, {1, 0, 0.2}, {0, 1, 0.7});
  CHECK(std::abs(distance_by_subdivision(a, 0, b) - 0.7) <= kTightnessError);
  // Two parallel sheets: the point of A that is farthest from both is inside.
  Mesh sheets = shapes::triangle({-9, -9, 0}, {9, -9, 0}, {0, 9, 0});
  sheets.positions.insert(sheets.positions.end(), {{-9, -9, 1}, {9, -9, 1}, {0, 9, 1}});
  sheets.triangles.push_back({3, 4, 5});
  a = shapes::triangle({0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0.875});
  CHECK(std::abs(distance_by_subdivision(a, 0, sheets) - 0.5) <= kTightnessError);
}

TEST_CASE("tightness: no bound is below h, none rises from stencil to stencil, triangle_set's is the least of all") {
  std::mt19937_64 random(22);
  int loose = 0, gained = 0;
  for (int round = 0; round < 80; ++round) {
    Measured f(shapes::scaled(shapes::soup(4, random), round % 2 ? 0.5 : 0.05), shapes::soup(60, random));
    const MeshView b = f.b;
    for (std::uint32_t t = 0; t < 4; ++t) {
      const Piece piece = f.piece(t);
      const double h = distance_by_subdivision(f.a, t, f.b), set = f.triangle_set(piece);
      double least = std::numeric_limits<double>::infinity();
      for (std::uint32_t k = 0; k < 60; ++k) {
        const PreparedTriangle triangle = prepare(b.corner(k, 0), b.corner(k, 1), b.corner(k, 2)).triangle;
        double farthest = 0;
        for (const Corner& corner : piece.corners) farthest = std::max(farthest, distance(triangle, corner.point));
        least = std::min(least, farthest);
      }
      CHECK(set == doctest::Approx(least).epsilon(1e-14));
      CHECK(set >= h - kTightnessError);
      double before = f.four_point(piece);
      loose += before > set;
      for (const int points : {4, 10, 31, 109, 409}) {
        const double upper = f.n_point(points, piece);
        CHECK(upper <= before);
        CHECK(upper >= set);
        gained += upper < before;
        before = upper;
      }
    }
  }
  CHECK(loose > 30);
  CHECK(gained > 30);
}
