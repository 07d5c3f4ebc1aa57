#include "oracle/exact.h"

#include <algorithm>
#include <cassert>

namespace meshgauge::oracle {
namespace {

Ratio distance_to_segment_sq(const Point& p, const Point& a, const Point& b) {
  const Point ab = b - a, ap = p - a;
  const Dyadic along = dot(ap, ab), length_sq = dot(ab, ab);
  if (along.sign() <= 0) return {dot(ap, ap), 1.0};  // also where a = b
  if (along >= length_sq) {
    const Point bp = p - b;
    return {dot(bp, bp), 1.0};
  }
  return {dot(ap, ap) * length_sq - along * along, length_sq};
}

// Whether p, projected along n, lies inside of the edge from -> to, or on it.
bool is_left_of(const Point& p, const Point& from, const Point& to, const Point& n) {
  return dot(cross(to - from, p - from), n).sign() >= 0;
}

}  // namespace

Point exact(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

Dyadic dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Surface surface_of(const Mesh& mesh) {
  Surface surface;
  surface.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    surface.push_back({exact(mesh.positions[t[0]]), exact(mesh.positions[t[1]]), exact(mesh.positions[t[2]])});
  }
  return surface;
}

Surface times(const Surface& surface, double factor) {
  Surface result;
  result.reserve(surface.size());
  for (const auto& [a, b, c] : surface) result.push_back({factor * a, factor * b, factor * c});
  return result;
}

Ratio distance_sq(const Point& p, const Corners& triangle) {
  const auto& [a, b, c] = triangle;
  const Point n = cross(b - a, c - a);
  const Dyadic n_sq = dot(n, n);
  if (n_sq.sign() > 0 && is_left_of(p, a, b, n) && is_left_of(p, b, c, n) && is_left_of(p, c, a, n)) {
    const Dyadic height = dot(p - a, n);
    return {height * height, n_sq};
  }
  return std::min({distance_to_segment_sq(p, a, b), distance_to_segment_sq(p, b, c), distance_to_segment_sq(p, c, a)});
}

Ratio distance_sq(const Point& p, const Surface& surface) {
  assert(!surface.empty());
  Ratio best = distance_sq(p, surface.front());
  for (std::size_t t = 1; t < surface.size(); ++t) best = std::min(best, distance_sq(p, surface[t]));
  return best;
}

bool are_inside(const Weights& w) {
  return w.first >= 0 && w.second >= 0 && (Dyadic(w.first) + Dyadic(w.second)) <= Dyadic(1.0);
}

Point point_at(const Corners& triangle, const Weights& w) {
  const Dyadic first = w.first, second = w.second;
  return first * triangle[0] + second * triangle[1] + (Dyadic(1.0) - first - second) * triangle[2];
}

bool root_at_least(const Ratio& sq, const Dyadic& bound) { return sq.numerator >= bound * bound * sq.denominator; }

bool root_at_most(const Ratio& sq, const Dyadic& bound) { return sq.numerator <= bound * bound * sq.denominator; }

// With x, y the squares: sqrt(x) >= bound + sqrt(y)  <=>  x - y - bound^2 >= 2 bound sqrt(y)
//   <=>  the left side is >= 0 and its square is >= 4 bound^2 y.
bool difference_at_least(const Ratio& large_sq, const Ratio& small_sq, double bound) {
  const Ratio &x = large_sq, &y = small_sq;
  const Dyadic bound_sq = Dyadic(bound) * Dyadic(bound);
  const Dyadic common = x.denominator * y.denominator;
  const Dyadic left = x.numerator * y.denominator - y.numerator * x.denominator - bound_sq * common;
  if (left.sign() < 0) return false;
  return left * left * y.denominator >= Dyadic(4.0) * bound_sq * y.numerator * common * common;
}

}  // namespace meshgauge::oracle
