// Sums over the coordinates of a vector, always from the first one to the last: (x + y) + z.
//
// Eigen's dot(), norm(), squaredNorm(), normalized(), L1 norm, trace() and products of matrices add in another
// order where it does not vectorise, as in WebAssembly, and fuse on arm64. The engine and the readers use these
// functions instead, so that the bits of a result do not depend on the machine. `./dev lint sums` refuses Eigen's.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace meshgauge {

using Vec3 = Eigen::Vector3d;

// Takes vectors or expressions with two or three coordinates. None is stored in between, which GCC 12 does not optimise
// away.
template <class A, class B>
double dot(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  constexpr int kSize = A::SizeAtCompileTime;
  static_assert((kSize == 2 || kSize == 3) && kSize == int{B::SizeAtCompileTime});
  const double plane = a.derived().coeff(0) * b.derived().coeff(0) + a.derived().coeff(1) * b.derived().coeff(1);
  if constexpr (kSize == 2) return plane;
  return plane + a.derived().coeff(kSize - 1) * b.derived().coeff(kSize - 1);
}

template <class A>
double squared_norm(const Eigen::MatrixBase<A>& a) {
  constexpr int kSize = A::SizeAtCompileTime;
  static_assert(kSize == 2 || kSize == 3);
  const double x = a.derived().coeff(0), y = a.derived().coeff(1), plane = x * x + y * y;
  if constexpr (kSize == 2) return plane;
  const double z = a.derived().coeff(kSize - 1);
  return plane + z * z;
}

template <class A>
double norm(const Eigen::MatrixBase<A>& a) {
  return std::sqrt(squared_norm(a));
}

// Returns `a` at length 1; `a` itself where its squared norm is 0 or NaN.
inline Vec3 normalized(const Vec3& a) {
  const double sq = squared_norm(a);
  return sq > 0 ? Vec3(a / std::sqrt(sq)) : a;
}

// Returns |a| within a relative error of 8u, also where squares would overflow or underflow: those summed are at
// most 1. Precondition: `a` is finite.
inline double scaled_norm(const Vec3& a) {
  const double most = a.cwiseAbs().maxCoeff();
  return most > 0 ? most * norm(a / most) : 0;
}

// The product of a matrix of 3 x 3 with a vector or a matrix; each entry is a sum in the order of the columns of `m`.
template <class M, class N>
Eigen::Matrix<double, 3, N::ColsAtCompileTime> product(const Eigen::MatrixBase<M>& m, const Eigen::MatrixBase<N>& n) {
  Eigen::Matrix<double, 3, N::ColsAtCompileTime> all;
  for (int k = 0; k < n.cols(); ++k) {
    for (int i = 0; i < 3; ++i) all(i, k) = m(i, 0) * n(0, k) + m(i, 1) * n(1, k) + m(i, 2) * n(2, k);
  }
  return all;
}

}  // namespace meshgauge
