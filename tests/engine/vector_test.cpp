// Sums whose bits depend on the order: each is the one spelled out here, on every machine and with every compiler.
#include "engine/vector.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

using namespace meshgauge;

namespace {

Vec3 any_vector(std::mt19937_64& bits) {
  Vec3 v;
  for (int k = 0; k < 3; ++k) v[k] = std::ldexp(static_cast<double>(bits() >> 11), -52) - 1;
  return v;
}

double forward(double x, double y, double z) { return (x + y) + z; }
double backward(double x, double y, double z) { return x + (y + z); }

}  // namespace

TEST_CASE("vector: sums run from the first coordinate to the last") {
  CHECK(dot(Vec3(1, 0x1p-53, 0x1p-53), Vec3(1, 1, 1)) == 1);
  CHECK(dot(Vec3(0x1p-53, 0x1p-53, 1), Vec3(1, 1, 1)) == 1 + 0x1p-52);
  CHECK(squared_norm(Vec3(1, 0x1.6p-27, 0x1.6p-27)) == 1);
  CHECK(squared_norm(Vec3(0x1.6p-27, 0x1.6p-27, 1)) == 1 + 0x1p-52);
  Eigen::Matrix3d rows;
  rows << 1, 0x1p-53, 0x1p-53, 0x1p-53, 0x1p-53, 1, 1, 0x1p-53, 0x1p-53;
  CHECK(product(rows, Vec3(1, 1, 1)) == Vec3(1, 1 + 0x1p-52, 1));

  std::mt19937_64 bits(1);
  int differing = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 u = any_vector(bits), v = any_vector(bits), d = u - v;
    CHECK(dot(u, v) == forward(u[0] * v[0], u[1] * v[1], u[2] * v[2]));
    CHECK(squared_norm(u - v) == forward(d[0] * d[0], d[1] * d[1], d[2] * d[2]));
    CHECK(norm(u - v) == std::sqrt(forward(d[0] * d[0], d[1] * d[1], d[2] * d[2])));
    CHECK(normalized(u) == Vec3(u[0] / norm(u), u[1] / norm(u), u[2] / norm(u)));
    Eigen::Matrix3d m;
    m << u, v, d;
    const Vec3 w = any_vector(bits);
    const Vec3 by_column = product(m, w), by_row = product(m.transpose(), w);
    for (int k = 0; k < 3; ++k) {
      CHECK(by_column[k] == forward(u[k] * w[0], v[k] * w[1], d[k] * w[2]));
      CHECK(by_row[k] == dot(m.col(k), w));
    }
    CHECK(product(m, m).col(2) == product(m, d));
    differing += forward(u[0] * v[0], u[1] * v[1], u[2] * v[2]) != backward(u[0] * v[0], u[1] * v[1], u[2] * v[2]);
  }
  CHECK(differing > 100);
}

TEST_CASE("vector: no product is fused with a sum") {
  constexpr double kSmall = 0x1p-30;  // (1 + s)(1 - s) rounds to 1
  CHECK(dot(Eigen::Vector2d(1 + kSmall, 1), Eigen::Vector2d(1 - kSmall, -1)) == 0);
  CHECK(dot(Vec3(-1, 1 + kSmall, 0), Vec3(1, 1 - kSmall, 0)) == 0);
  CHECK(dot(Vec3(-1, 0, 1 + kSmall), Vec3(1, 0, 1 - kSmall)) == 0);
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.row(0) = Eigen::RowVector3d(-1, 1 + kSmall, 0);
  CHECK(product(m, Vec3(1, 1 - kSmall, 0))[0] == 0);
}

TEST_CASE("vector: lengths whose squares overflow or underflow") {
  CHECK(scaled_norm(Vec3(3e300, 4e300, 0)) == doctest::Approx(5e300));
  CHECK(scaled_norm(Vec3(-3e-300, 0, 4e-300)) == doctest::Approx(5e-300));
  CHECK(scaled_norm(Vec3::Zero()) == 0);
  std::mt19937_64 bits(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 v = any_vector(bits);
    const double most = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    const Vec3 shares(v[0] / most, v[1] / most, v[2] / most);
    CHECK(scaled_norm(v) == most * std::sqrt(dot(shares, shares)));
    CHECK(scaled_norm(v) == doctest::Approx(norm(v)).epsilon(0x1p-50));
  }
}
