// Distances to triangles in extended precision, by the plainest formulas.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "engine/mesh.h"

namespace meshgauge::oracle {

using Point3 = Eigen::Matrix<long double, 3, 1>;
using LongTriangle = std::array<Point3, 3>;

inline LongTriangle long_triangle(const Mesh& mesh, const Triangle& t) {
  return {mesh.positions[t[0]].cast<long double>(), mesh.positions[t[1]].cast<long double>(),
          mesh.positions[t[2]].cast<long double>()};
}

inline long double to_segment(const Point3& p, const Point3& a, const Point3& b) {
  const Point3 ab = b - a;
  const long double length_sq = ab.squaredNorm();
  const long double s = length_sq > 0 ? std::clamp((p - a).dot(ab) / length_sq, 0.0L, 1.0L) : 0.0L;
  return (p - a - s * ab).norm();
}

// The distance to the plane where the foot is inside of all edges, else to the nearest edge.
inline long double to_triangle(const Point3& p, const LongTriangle& t) {
  const Point3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const long double length = normal.norm();
  long double least = std::min({to_segment(p, t[0], t[1]), to_segment(p, t[1], t[2]), to_segment(p, t[2], t[0])});
  if (!(length > 0)) return least;
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3& a = t[i];
    inside = inside && normal.dot((t[(i + 1) % 3] - a).cross(p - a)) >= 0;
  }
  if (inside) least = std::min(least, std::abs((p - t[0]).dot(normal)) / length);
  return least;
}

inline std::vector<LongTriangle> long_triangles(const Mesh& mesh) {
  std::vector<LongTriangle> all;
  for (const Triangle& t : mesh.triangles) all.push_back(long_triangle(mesh, t));
  return all;
}

inline long double to_nearest(const Point3& p, const std::vector<LongTriangle>& triangles) {
  long double least = to_triangle(p, triangles[0]);
  for (const LongTriangle& t : triangles) least = std::min(least, to_triangle(p, t));
  return least;
}

}  // namespace meshgauge::oracle
