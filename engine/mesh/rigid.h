// Rigid motion of a mesh by a matrix, with the rounding error.
#pragma once

#include <optional>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/scaling.h"

namespace meshgauge {

// x -> rotation * x + translation, for the numbers as they are. The rotation is orthonormal up to kOrthonormal.
struct RigidMotion {
  using Matrix = Eigen::Matrix3d;
  // The largest |entry| of rotation^T * rotation - 1 of a rotation that is used as it is: rounding alone.
  static constexpr double kOrthonormal = 0x1p-48;

  Matrix rotation = Matrix::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return product(rotation, p) + translation; }
  // Inverse up to rounding.
  RigidMotion inverse() const { return {rotation.transpose(), -product(rotation.transpose(), translation)}; }
  bool is_identity() const { return *this == RigidMotion(); }
  bool operator==(const RigidMotion&) const = default;
};

// The largest |entry| of m^T * m - 1; NaN or infinite where m is so large.
double off_orthonormal(const RigidMotion::Matrix& m);

// Returns the rotation nearest to `m`, orthonormal up to rounding. Precondition: m is finite, its determinant above 0.
RigidMotion::Matrix nearest_rotation(const RigidMotion::Matrix& m);

// How far a motion moves a mesh, in its unit; rounded, not certified.
struct Displacement {
  double angle = 0;    // of the rotation, in degrees, from 0 to 180
  double shift = 0;    // of the centre of the mesh's bounding box
  double largest = 0;  // of a point of the surface
};

// Precondition: the mesh passes validate(). Linear time. nullopt: interrupted.
std::optional<Displacement> displacement(MeshView mesh, const Box& box, const RigidMotion& motion,
                                         const Interrupted& interrupted = never_interrupted);

// Returns the moved positions. RoundedImage::error holds for the exact image of the surface that is at most `error`
// from `mesh` (engine/rounding.h R17); it is 0 where `error` is 0 and nothing was rounded. nullopt: interrupted, or a
// moved coordinate that a triangle uses is beyond kMaxCoordinate. A vertex that no triangle uses is moved,
// too, and does not count for the error. Precondition: the mesh passes validate(). Linear time.
std::optional<RoundedImage> moved(MeshView mesh, const RigidMotion& motion, double error = 0,
                                  const Interrupted& interrupted = never_interrupted);

}  // namespace meshgauge
