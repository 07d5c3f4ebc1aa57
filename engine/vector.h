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

// The sum of the coordinates, two or three.
template <int kSize>
[[gnu::always_inline]] inline double sum_in_order(const Eigen::Matrix<double, kSize, 1>& v) {
  static_assert(kSize == 2 || kSize == 3);
  if constexpr (kSize == 2) return v[0] + v[1];
  return (v[0] + v[1]) + v[kSize - 1];
}

// Takes vectors or expressions. Always inlined, as a call costs as much as the sum. The products are formed first, side
// by side where Eigen vectorises, and they alone are stored: GCC 12 does not optimise stored vectors away.
template <class A, class B>
[[gnu::always_inline]] inline double dot(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return sum_in_order<A::SizeAtCompileTime>(a.cwiseProduct(b));
}

template <class A>
[[gnu::always_inline]] inline double squared_norm(const Eigen::MatrixBase<A>& a) {
  return sum_in_order<A::SizeAtCompileTime>(a.cwiseAbs2());
}

template <class A>
[[gnu::always_inline]] inline double norm(const Eigen::MatrixBase<A>& a) {
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
