#include "fuzz/shrink.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace meshgauge::fuzz {
namespace {

using Clock = std::chrono::steady_clock;

class Shrinker {
 public:
  Shrinker(Pair pair, const std::function<bool(const Pair&)>& fails, Clock::time_point end)
      : pair_(std::move(pair)), fails_(fails), end_(end) {}

  Pair run() {
    bool changed = true;
    while (changed && !out_of_time()) {
      changed = false;
      for (Mesh Pair::*side : {&Pair::a, &Pair::b}) {
        changed |= drop_triangles(side);
        changed |= drop_vertices(side);
        changed |= simplify_coordinates(side);
      }
    }
    return pair_;
  }

 private:
  bool out_of_time() const { return Clock::now() >= end_; }

  bool keep_if_it_fails(Pair candidate) {
    if (out_of_time() || !fails_(candidate)) return false;
    pair_ = std::move(candidate);
    return true;
  }

  bool drop_triangles(Mesh Pair::*side) {
    bool changed = false;
    for (std::size_t t = (pair_.*side).triangles.size(); t-- > 0;) {
      if ((pair_.*side).triangles.size() == 1) break;
      Pair candidate = pair_;
      auto& triangles = (candidate.*side).triangles;
      triangles.erase(triangles.begin() + static_cast<std::ptrdiff_t>(t));
      changed |= keep_if_it_fails(std::move(candidate));
    }
    return changed;
  }

  bool drop_vertices(Mesh Pair::*side) {
    bool changed = false;
    for (std::size_t v = (pair_.*side).positions.size(); v-- > 0;) {
      Pair candidate = pair_;
      Mesh& mesh = candidate.*side;
      const auto uses = [&](const Triangle& t) { return std::count(t.begin(), t.end(), v) > 0; };
      if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(), uses)) continue;
      mesh.positions.erase(mesh.positions.begin() + static_cast<std::ptrdiff_t>(v));
      for (Triangle& t : mesh.triangles) {
        for (std::uint32_t& i : t) i -= i > v;
      }
      changed |= keep_if_it_fails(std::move(candidate));
    }
    return changed;
  }

  bool simplify_coordinates(Mesh Pair::*side) {
    bool changed = false;
    for (std::size_t v = 0; v < (pair_.*side).positions.size(); ++v) {
      for (int k = 0; k < 3; ++k) changed |= simplify(side, v, k);
    }
    return changed;
  }

  // Takes the first of 0, 1, a whole number, and 4, 8, 16, 32 bits with which the pair still fails.
  bool simplify(Mesh Pair::*side, std::size_t v, int k) {
    const double x = (pair_.*side).positions[v][k];
    if (!std::isfinite(x)) return false;
    for (const double simpler :
         {0.0, 1.0, std::round(x), to_bits(x, 4), to_bits(x, 8), to_bits(x, 16), to_bits(x, 32)}) {
      if (simpler == x) return false;
      Pair candidate = pair_;
      (candidate.*side).positions[v][k] = simpler;
      if (keep_if_it_fails(std::move(candidate))) return true;
    }
    return false;
  }

  static double to_bits(double x, int bits) {
    int exponent = 0;
    return std::ldexp(std::round(std::ldexp(std::frexp(x, &exponent), bits)), exponent - bits);
  }

  Pair pair_;
  const std::function<bool(const Pair&)>& fails_;
  Clock::time_point end_;
};

}  // namespace

Pair shrink(Pair pair, const std::function<bool(const Pair&)>& fails, std::chrono::milliseconds patience) {
  return Shrinker(std::move(pair), fails, Clock::now() + patience).run();
}

std::string to_obj(const Mesh& mesh) {
  std::string text;
  char line[120];
  for (const Vec3& p : mesh.positions) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    text += line;
  }
  for (const Triangle& t : mesh.triangles) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    text += line;
  }
  return text;
}

}  // namespace meshgauge::fuzz
