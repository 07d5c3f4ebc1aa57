#include "engine/tree/triangle.h"

#include "engine/kernels/layout.h"
#include "engine/rounding.h"

namespace meshgauge {
Preparation prepare(const Vec3& a0, const Vec3& b0, const Vec3& c0) {
  const double ab = squared_norm(b0 - a0);
  const double bc = squared_norm(c0 - b0);
  const double ca = squared_norm(a0 - c0);
  Vec3 a = a0, b = b0, c = c0;
  if (bc > ab && bc >= ca) {
    a = b0, b = c0, c = a0;
  } else if (ca > ab && ca > bc) {
    a = c0, b = a0, c = b0;
  }

  PreparedTriangle t{a, Vec3::Zero(), Vec3::Zero()};
  t.length = norm(b - a);
  if (t.length < kNegligibleLength) {
    t.length = 0;
  } else {
    t.e1 = (b - a) / t.length;
    const Vec3 ac = c - a;
    t.cx = std::clamp(dot(ac, t.e1), 0.0, t.length);
    Vec3 across = ac - dot(ac, t.e1) * t.e1;
    across -= dot(across, t.e1) * t.e1;  // once more: orthogonal to rounding even where `across` is tiny
    t.cy = norm(across);
    if (t.cy < kNegligibleLength) {
      t.cy = 0;
    } else {
      t.e2 = across / t.cy;
    }
  }
  const double at_b = norm(t.a + t.length * t.e1 - b);
  const double at_c = norm(t.a + t.cx * t.e1 + t.cy * t.e2 - c);
  return {t, std::max(at_b, at_c) + rounding::kResidualSlack};
}

}  // namespace meshgauge
