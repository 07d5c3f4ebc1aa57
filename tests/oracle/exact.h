// The exact geometry of the oracle: squared distances as ratios of big integers. The only code that it shares with the
// engine are the plain structs of engine/mesh.h.
#pragma once

#include <array>
#include <vector>

#include "engine/mesh.h"
#include "oracle/dyadic.h"

namespace meshgauge::oracle {

struct Point {
  Dyadic x, y, z;

  friend Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Point operator*(const Dyadic& s, const Point& p) { return {s * p.x, s * p.y, s * p.z}; }
  friend bool operator==(const Point& a, const Point& b) = default;
};

Point exact(const Vec3& p);  // precondition: finite
Dyadic dot(const Point& a, const Point& b);
Point cross(const Point& a, const Point& b);

using Corners = std::array<Point, 3>;

// The surface of a mesh: its triangles.
using Surface = std::vector<Corners>;
Surface surface_of(const Mesh& mesh);
Surface times(const Surface& surface, double factor);  // exact

// The squared distance to a triangle, which may be degenerate: a segment or a point.
Ratio distance_sq(const Point& p, const Corners& triangle);
// The squared distance to the nearest triangle. Precondition: the surface has one.
Ratio distance_sq(const Point& p, const Surface& surface);

// The position of a point in a triangle: v0 * first + v1 * second + v2 * (1 - first - second).
struct Weights {
  double first = 1;
  double second = 0;
};
// Whether the exact weights are those of a point of the triangle.
bool are_inside(const Weights& weights);
Point point_at(const Corners& triangle, const Weights& weights);

// Exact comparisons of square roots of ratios. Precondition: bounds are finite and >= 0.
bool root_at_least(const Ratio& sq, const Dyadic& bound);  // sqrt(sq) >= bound
bool root_at_most(const Ratio& sq, const Dyadic& bound);   // sqrt(sq) <= bound
bool difference_at_least(const Ratio& large_sq, const Ratio& small_sq,
                         double bound);  // sqrt(large_sq) - sqrt(small_sq) >= bound

}  // namespace meshgauge::oracle
