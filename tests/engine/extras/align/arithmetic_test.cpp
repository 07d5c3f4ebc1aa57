#include "engine/extras/align/arithmetic.h"

#include <array>
#include <random>

#include <doctest/doctest.h>
#include <Eigen/Cholesky>

using namespace meshgauge;

namespace {

double any_number(std::mt19937_64& bits) { return std::uniform_real_distribution<double>(-1, 1)(bits); }

Vec3 any_vector(std::mt19937_64& bits) { return {any_number(bits), any_number(bits), any_number(bits)}; }

double difference(const Turn& a, const Turn& b) { return (a.coeffs() - b.coeffs()).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("align: turns by angles are those of sine and cosine") {
  std::mt19937_64 bits(5);
  for (const double angle : {0.0, 1e-300, 1e-9, 0.1, 0.35, 1.0, 3.0, 20.0}) {
    const Vec3 axis = normalized(any_vector(bits));
    CAPTURE(angle);
    const Turn turn = turn_by(angle * axis);
    CHECK(difference(turn, Turn(Eigen::AngleAxisd(angle, axis))) < 1e-15 * (4 + angle));
    const Turn other = turn_by(any_vector(bits));
    CHECK(difference(composed(turn, other), turn * other) < 1e-15);
  }
  CHECK_FALSE(turn_by(Vec3(1e200, 0, 0)).coeffs().allFinite());
}

TEST_CASE("align: equations are solved, also those that leave directions open") {
  std::mt19937_64 bits(6);
  for (int rank = 0; rank <= 6; ++rank) {
    Mat6 a = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    for (int row = 0; row < 2 * rank; ++row) {
      Vec6 v = Vec6::Zero();
      for (int k = 0; k < rank; ++k) v[(k + 2) % 6] = any_number(bits);
      a += v * v.transpose();
      b += v * any_number(bits);
    }
    CAPTURE(rank);
    const Vec6 x = solve(a, b);
    CHECK((a * x - b).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((x - Vec6(a.ldlt().solve(b))).cwiseAbs().maxCoeff() < 1e-10);
  }
}
