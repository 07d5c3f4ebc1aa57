#include "engine/extras/align/arithmetic.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace meshgauge {

Turn composed(const Turn& second, const Turn& first) {
  const Vec3 v = second.vec(), t = first.vec();
  const double scalar = second.w() * first.w() - dot(v, t);
  const Vec3 vector = second.w() * t + first.w() * v + v.cross(t);
  const double length = std::sqrt(squared_norm(vector) + scalar * scalar);
  return {scalar / length, vector[0] / length, vector[1] / length, vector[2] / length};
}

// exp(v / 2): the series for the half taken often enough, then that many squares. The terms left out are below 2^-60.
Turn turn_by(const Vec3& v) {
  constexpr int kMost = 64;
  Vec3 half = v / 2;
  int halvings = 0;
  for (; squared_norm(half) > 0x1p-8 && halvings < kMost; ++halvings) half /= 2;
  const double sq = squared_norm(half);
  const double cosine = 1 - sq / 2 * (1 - sq / 12 * (1 - sq / 30 * (1 - sq / 56)));
  const double sine = 1 - sq / 6 * (1 - sq / 20 * (1 - sq / 42 * (1 - sq / 72)));  // divided by the angle
  Turn turn(cosine, sine * half[0], sine * half[1], sine * half[2]);
  for (; halvings > 0; --halvings) turn = composed(turn, turn);
  return turn;
}

// Elimination with the largest entry of the diagonal first. What is left when that is 0 is 0, up to rounding.
Vec6 solve(Mat6 a, Vec6 b) {
  std::array<int, 6> order{0, 1, 2, 3, 4, 5};
  int rank = 0;
  for (; rank < 6; ++rank) {
    int pivot = rank;
    for (int i = rank + 1; i < 6; ++i) pivot = a(i, i) > a(pivot, pivot) ? i : pivot;
    if (!(a(pivot, pivot) > std::numeric_limits<double>::min())) break;
    a.row(rank).swap(a.row(pivot));
    a.col(rank).swap(a.col(pivot));
    std::swap(b[rank], b[pivot]);
    std::swap(order[static_cast<std::size_t>(rank)], order[static_cast<std::size_t>(pivot)]);
    for (int i = rank + 1; i < 6; ++i) {
      const double factor = a(i, rank) / a(rank, rank);
      for (int j = rank + 1; j < 6; ++j) a(i, j) -= factor * a(rank, j);
      b[i] -= factor * b[rank];
    }
  }
  Vec6 x = Vec6::Zero();
  for (int i = rank; i-- > 0;) {
    double rest = b[i];
    for (int j = i + 1; j < rank; ++j) rest -= a(i, j) * x[order[static_cast<std::size_t>(j)]];
    x[order[static_cast<std::size_t>(i)]] = rest / a(i, i);
  }
  return x;
}

}  // namespace meshgauge
