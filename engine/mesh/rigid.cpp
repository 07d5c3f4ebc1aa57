#include "engine/mesh/rigid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

// A rounded number and how far it is from the exact one.
struct Rounded {
  double value;
  double error;
};

// Exactly a + b = value + error (Knuth).
Rounded sum_of(double a, double b) {
  const double sum = a + b, part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

// row . p + translation as if computed with twice the digits: R17.
Rounded coordinate(const Vec3& row, const Vec3& p, double translation) {
  Rounded all{translation, 0};
  double lost = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    const double product = row[k] * p[k], off = std::fma(row[k], p[k], -product);
    const Rounded sum = sum_of(all.value, product);
    all.value = sum.value;
    lost += off + sum.error;
    size += std::abs(off) + std::abs(sum.error);
  }
  const Rounded last = sum_of(all.value, lost);
  return {last.value, std::abs(last.error) + rounding::kMotionSlack * size};
}

// Whether each product with an entry is exact.
bool moves_axes(const RigidMotion::Matrix& m) { return (m.array() == 0 || m.array().abs() == 1).all(); }

}  // namespace

double off_orthonormal(const RigidMotion::Matrix& m) {
  return (product(m.transpose(), m) - RigidMotion::Matrix::Identity()).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

RigidMotion::Matrix nearest_rotation(const RigidMotion::Matrix& m) {
  const Eigen::JacobiSVD<RigidMotion::Matrix> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return product(svd.matrixU(), svd.matrixV().transpose());
}

std::optional<Displacement> displacement(MeshView mesh, const Box& box, const RigidMotion& motion,
                                         const Interrupted& interrupted) {
  const auto& r = motion.rotation;
  const Vec3 skew(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));  // 2 sin(angle) times the axis
  const auto moves = [&motion](const Vec3& p) { return scaled_norm(motion(p) - p); };
  Displacement found;
  // Only shown: atan2() may differ in its last digits.
  found.angle = std::atan2(norm(skew), r(0, 0) + (r(1, 1) + r(2, 2)) - 1) * 180 / std::numbers::pi;
  found.shift = moves(box.low / 2 + box.high / 2);
  const bool done = each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
    for (const std::uint32_t v : mesh.triangles[t]) found.largest = std::max(found.largest, moves(mesh.positions[v]));
  });
  return done ? std::optional(found) : std::nullopt;
}

std::optional<RoundedImage> moved(MeshView mesh, const RigidMotion& motion, double error,
                                  const Interrupted& interrupted) {
  std::vector<bool> used(mesh.positions.size());
  const bool marked = each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
    for (const std::uint32_t v : mesh.triangles[t]) used[v] = true;
  });
  if (!marked) return std::nullopt;
  RoundedImage result;
  result.positions.resize(mesh.positions.size());
  double largest = 0;
  bool too_large = false;
  const bool all = each_unless(interrupted, mesh.positions.size(), [&](std::uint32_t v) {
    for (int k = 0; k < 3; ++k) {
      const Rounded moved = coordinate(motion.rotation.row(k), mesh.positions[v], motion.translation[k]);
      result.positions[v][k] = moved.value;
      if (!used[v]) continue;
      too_large = too_large || !(std::abs(moved.value) <= kMaxCoordinate);
      largest = std::max(largest, moved.error);
    }
  });
  if (!all || too_large) return std::nullopt;
  result.error = rounding::motion_error(largest, moves_axes(motion.rotation), error);
  return result;
}

}  // namespace meshgauge
