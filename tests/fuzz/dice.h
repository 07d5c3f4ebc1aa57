// Random numbers that are the same with every standard library.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "engine/mesh.h"

namespace meshgauge::fuzz {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {
    random_.discard(2);  // neighbouring seeds begin with similar numbers
  }

  std::uint64_t bits() { return random_(); }
  // Uniform in 0 .. n-1.
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>((random_() >> 32) * n >> 32); }
  int between(int low, int high) { return low + static_cast<int>(below(static_cast<std::uint32_t>(high - low + 1))); }
  bool chance(double p) { return unit() < p; }
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  double sign() { return chance(0.5) ? 1 : -1; }
  // 10^x with uniform x.
  double power(double low, double high) { return std::pow(10.0, uniform(low, high)); }

  Vec3 point(double size = 1) {
    const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
    return {x, y, z};
  }
  Vec3 lattice(int n) {
    const int x = between(0, n), y = between(0, n), z = between(0, n);
    return {double(x), double(y), double(z)};
  }
  template <class T, std::size_t N>
  const T& pick(const T (&items)[N]) {
    return items[below(static_cast<std::uint32_t>(N))];
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace meshgauge::fuzz
