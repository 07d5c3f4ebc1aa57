// A bound that needs no triangle of B.
//
// Statement. Let p_i be the corners of a piece P and R the radius of the smallest circle around it. Then
//   h(P,B) <= max d(p_i,B) + R.
// Proof. Let m be the circle's centre and x in P, a convex combination of the corners: sum w_i (p_i - x) = 0, so for
// some i (p_i - x).(m - x) <= 0, and then |p_i - m|^2 >= |p_i - x|^2 + |x - m|^2. So |p_i - x| <= |p_i - m| <= R, and
// d(.,B) is 1-Lipschitz.
//
// Rounding. The computed R errs by less than 32u relative: 5u for each square, which the well conditioned area
// amplifies by no more than 4. kRoundUp = 1 + 64u covers it. The final sum errs by 4u, for which kDistanceSlack has
// room: the distances themselves need 51u of its 64u (rounding.h, R3).
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/search/piece.h"

namespace meshgauge {

// Returns R: half of the longest edge if the angle opposite is obtuse or right, else the circumradius. The computed
// value may be some units of rounding too small.
inline double enclosing_radius(const Vec3& a, const Vec3& b, const Vec3& c) {
  double x = squared_norm(b - a), y = squared_norm(c - b), z = squared_norm(a - c);
  if (x < y) std::swap(x, y);
  if (x < z) std::swap(x, z);
  if (x >= y + z) return 0.5 * std::sqrt(x);
  // 16 area^2 = 4yz - (y+z-x)^2; well conditioned, because the angle opposite the longest edge is within 60..90
  // degrees.
  const double area_sq_16 = 4 * y * z - (y + z - x) * (y + z - x);
  const double half = 0.5 * std::sqrt(x);  // R is never below this, nor above 2/sqrt(3) times this
  if (!(area_sq_16 > 0)) return 1.1547005383792517 * half;
  return std::clamp(std::sqrt(x * y * z / area_sq_16), half, 1.1547005383792517 * half);
}

// Returns the bound of h(piece, B), rounded up as derived above.
inline double lipschitz_upper(const Piece& piece) {
  const auto& [a, b, c] = piece.corners;
  constexpr double kRoundUp = 1 + 0x1p-47;
  return std::max({a.distance, b.distance, c.distance}) + kRoundUp * enclosing_radius(a.point, b.point, c.point);
}

}  // namespace meshgauge
