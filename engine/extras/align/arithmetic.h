// What fitting needs of quaternions and equations, without functions whose last bits differ from machine to machine:
// sin() and cos(), and sums of Eigen (engine/vector.h).
#pragma once

#include <Eigen/Geometry>

#include "engine/vector.h"

namespace meshgauge {

using Turn = Eigen::Quaterniond;  // of length 1 up to rounding
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

// Returns the turn by |v| radians about v. Beyond 2^60 it is meaningless or not finite.
Turn turn_by(const Vec3& v);

// Returns `second` after `first`.
Turn composed(const Turn& second, const Turn& first);

// Solves a * x = b, x = 0 in directions in which `a` is 0. Precondition: `a` is symmetric and has no negative
// eigenvalue, up to rounding.
Vec6 solve(Mat6 a, Vec6 b);

}  // namespace meshgauge
