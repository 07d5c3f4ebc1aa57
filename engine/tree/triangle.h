// A triangle prepared for closest-point queries in its own plane frame.
//
// The corners are renamed so that ab is the longest edge; e1 is the direction of ab, e2 the direction from the line ab
// to c. With the longest edge as the base the computation is accurate to a few units of rounding for slivers of any
// width: the position along ab is well conditioned, and the position across is measured from the foot on ab, so the
// direction e2, which is ill conditioned in a sliver, is only multiplied by small numbers or errs in second order. (The
// usual barycentric formulas lose all digits on slivers 1e-8 wide.)
#pragma once

#include <algorithm>

#include "engine/mesh.h"

namespace meshgauge {

struct PreparedTriangle {
  Vec3 a;             // a corner; F = (0,0), (length,0), (cx,cy) in coordinates (e1,e2) from here
  Vec3 e1;            // unit vector along the longest edge; zero if the triangle is a point
  Vec3 e2;            // unit vector across; zero if the triangle is a segment or a point
  double length = 0;  // of the longest edge
  double cx = 0;      // 0 <= cx <= length
  double cy = 0;      // >= 0
};

struct Preparation {
  PreparedTriangle triangle;
  double residual = 0;  // largest distance of the prepared triangle from the given one: rounding.h R2
};

// Precondition: the corners lie in the unit frame. They may span a segment or a point.

Preparation prepare(const Vec3& a, const Vec3& b, const Vec3& c);

// Returns the point of the triangle closest to p, up to rounding.h R2. Precondition: p and the corners lie in the unit
// frame.
inline Vec3 closest_point(const PreparedTriangle& t, const Vec3& p) {
  const Vec3 ap = p - t.a;
  const double x = dot(ap, t.e1);
  const double y = dot(ap - x * t.e1, t.e2);
  if (y <= 0) return t.a + std::clamp(x, 0.0, t.length) * t.e1;

  const double dx = t.length - t.cx;
  const bool beyond_ac = t.cx * y - t.cy * x > 0;
  const bool beyond_bc = dx * y - t.cy * (t.length - x) > 0;
  if (!beyond_ac && !beyond_bc) return t.a + x * t.e1 + y * t.e2;

  const auto on_ac = [&] {
    const double s = std::clamp((x * t.cx + y * t.cy) / (t.cx * t.cx + t.cy * t.cy), 0.0, 1.0);
    return std::pair(s * t.cx, s * t.cy);
  };
  const auto on_bc = [&] {
    const double s = std::clamp(((t.length - x) * dx + y * t.cy) / (dx * dx + t.cy * t.cy), 0.0, 1.0);
    return std::pair(t.length - s * dx, s * t.cy);
  };
  auto [qx, qy] = beyond_ac ? on_ac() : on_bc();
  if (beyond_ac && beyond_bc) {
    const auto [rx, ry] = on_bc();
    const auto distance_sq = [&](double vx, double vy) { return (vx - x) * (vx - x) + (vy - y) * (vy - y); };
    if (distance_sq(rx, ry) < distance_sq(qx, qy)) qx = rx, qy = ry;
  }
  return t.a + qx * t.e1 + qy * t.e2;
}

}  // namespace meshgauge
