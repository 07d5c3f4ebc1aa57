#include "engine/tree/triangle.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "engine/rounding.h"
#include "engine/tree/nearest.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

// The distance in quadruple precision by another method: the nearest of the three segments and, where p projects
// inside, the plane. Slivers 1e-17 wide lose as many digits here, and 34 - 17 are left.
__extension__ typedef __float128 Real;
using RealVec = std::array<Real, 3>;

RealVec widen(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
RealVec minus(const RealVec& a, const RealVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Real dot(const RealVec& a, const RealVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
RealVec cross(const RealVec& a, const RealVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Real segment_distance_sq(const RealVec& p, const RealVec& a, const RealVec& b) {
  const RealVec d = minus(b, a), ap = minus(p, a);
  const Real dd = dot(d, d);
  const Real s = dd > 0 ? std::clamp<Real>(dot(ap, d) / dd, 0, 1) : Real(0);
  const RealVec away{ap[0] - s * d[0], ap[1] - s * d[1], ap[2] - s * d[2]};
  return dot(away, away);
}

double reference_distance(const Vec3& p0, const Vec3& a0, const Vec3& b0, const Vec3& c0) {
  const RealVec p = widen(p0), a = widen(a0), b = widen(b0), c = widen(c0);
  Real best_sq = std::min({segment_distance_sq(p, a, b), segment_distance_sq(p, b, c), segment_distance_sq(p, c, a)});
  const RealVec n = cross(minus(b, a), minus(c, a));
  const auto left_of = [&](const RealVec& from, const RealVec& to) {
    return dot(cross(minus(to, from), minus(p, from)), n) >= 0;
  };
  if (dot(n, n) > 0 && left_of(a, b) && left_of(b, c) && left_of(c, a)) {
    const Real height = dot(minus(p, a), n);
    best_sq = std::min(best_sq, height * height / dot(n, n));
  }
  return static_cast<double>(std::sqrt(static_cast<long double>(best_sq)));
}

void check(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Preparation prepared = prepare(a, b, c);
  CHECK(prepared.residual <= rounding::kResidualSlack + 16 * rounding::kUnit);
  const double computed = (p - closest_point(prepared.triangle, p)).norm();
  const double reference = reference_distance(p, a, b, c);
  const double slack = rounding::kDistanceSlack + prepared.residual;
  CHECK(computed >= reference - slack);
  CHECK(computed <= reference + slack);
}

}  // namespace

TEST_CASE("closest point of random triangles") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int i = 0; i < 20000; ++i) check(point(), point(), point(), point());
}

TEST_CASE("closest point of slivers of every width, from near and far") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int i = 0; i < 60000; ++i) {
    const Vec3 a = point() * 0.5, b = point() * 0.5;
    const double width = std::pow(10.0, -1 - 17 * std::abs(uniform(random)));
    const Vec3 c = a + (b - a) * (0.5 + 0.6 * uniform(random)) + width * point();
    const double away = std::pow(10.0, -17 * std::abs(uniform(random)));
    const Vec3 p = a + (b - a) * (0.5 + 0.7 * uniform(random)) + away * 0.3 * point();
    check(p, a, b, c);
    check(p, c, a, b);
    check(p, b, c, a);
  }
}

TEST_CASE("closest point of segments and points") {
  const Vec3 o(0, 0, 0), x(1, 0, 0), p(0.3, 0.4, 0);
  CHECK(meshgauge::distance(prepare(o, o, o).triangle, p) == doctest::Approx(0.5));
  CHECK(meshgauge::distance(prepare(o, x, o).triangle, p) == doctest::Approx(0.4));
  CHECK(meshgauge::distance(prepare(o, x * 0.5, x).triangle, p) == doctest::Approx(0.4));
  CHECK(meshgauge::distance(prepare(x, o, x * 0.25).triangle, Vec3(-0.3, 0.4, 0)) == doctest::Approx(0.5));
  const double tiny = 5e-324;
  CHECK(meshgauge::distance(prepare(o, Vec3(tiny, 0, 0), Vec3(0, tiny, 0)).triangle, p) == doctest::Approx(0.5));
}
