#include "engine/extras/area/weights.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr int kMostScaled = 900;  // a larger scale would enlarge what the frame lost of coordinates below 2^-1022

}  // namespace

AreaWeights::AreaWeights(const OrderedMesh& mesh, double error) : mesh_(mesh.view()) {
  const double width = (mesh.box.high - mesh.box.low).maxCoeff();
  const int exponent = width > 0 ? std::ilogb(width) : 0;
  scale_ = std::ldexp(1.0, std::clamp(-exponent, 0, kMostScaled));
  moved_ = 2 * error * scale_;
}

AreaWeights::Weight AreaWeights::of(std::size_t triangle) const {
  const Vec3 x = (mesh_.corner(triangle, 1) - mesh_.corner(triangle, 0)) * scale_;
  const Vec3 y = (mesh_.corner(triangle, 2) - mesh_.corner(triangle, 0)) * scale_;
  const double lengths = x.norm() + y.norm();
  const double error =
      rounding::kAreaSlack * (x.norm() * y.norm()) + (moved_ + rounding::kAreaOffset) * lengths + moved_ * moved_;
  const double area = x.cross(y).norm();
  return {std::max(area - error, 0.0), 2 * (error + rounding::kAreaOffset * rounding::kAreaOffset)};
}

}  // namespace meshgauge
