// How files place a part: x -> linear * x + translation. Not Eigen's transform, whose sums come out differently from
// machine to machine (engine/vector.h).
#pragma once

#include "engine/vector.h"

namespace meshgauge::api {

struct AffineMap {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return product(linear, p) + translation; }
};

// Returns the map that applies `inner` first.
inline AffineMap composed(const AffineMap& outer, const AffineMap& inner) {
  return {product(outer.linear, inner.linear), outer(inner.translation)};
}

}  // namespace meshgauge::api
