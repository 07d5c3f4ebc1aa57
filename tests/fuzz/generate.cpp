#include "fuzz/generate.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "fuzz/kinds.h"

namespace meshgauge::fuzz {
namespace {

template <class Change>
void for_each_position(Pair& pair, Change&& change) {
  for (Mesh* mesh : {&pair.a, &pair.b}) {
    for (Vec3& p : mesh->positions) change(p);
  }
}

void note(Pair& pair, const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  pair.what += text;
}

void rotate(Dice& dice, Pair& pair) {
  const Vec3 axis = (dice.point() + Vec3(0, 0, 2)).normalized();
  const Eigen::AngleAxisd turn(dice.uniform(0, 2 * std::numbers::pi), axis);
  for_each_position(pair, [&](Vec3& p) { p = turn * p; });
  pair.what += ", rotated";
}

// Moves the pair on all axes or on one.
void offset(Dice& dice, Pair& pair) {
  const double by = dice.sign() * dice.power(3, 12);
  const std::uint32_t axis = dice.below(4);
  Vec3 shift = Vec3::Constant(by);
  if (axis < 3) shift = by * Vec3::Unit(axis);
  if (dice.chance(0.2)) shift += Vec3(0, dice.power(0, 6), 0);
  for_each_position(pair, [&](Vec3& p) { p += shift; });
  note(pair, ", offset %.3g", by);
}

void part(Dice& dice, Pair& pair) {
  const Vec3 shift = dice.point(dice.power(-1, 3));
  for (Vec3& p : pair.b.positions) p += shift;
  pair.what += ", apart";
}

void scale(Dice& dice, Pair& pair) {
  static constexpr double kSizes[] = {1e-320, 1e-310, 1e-300, 1e-160, 1e-155, 1e-100, 1e-20, 1e-8,
                                      1e8,    1e20,   1e100,  1e150,  1e155,  1e300,  1e306};
  const double factor = dice.pick(kSizes);
  for_each_position(pair, [&](Vec3& p) { p *= factor; });
  note(pair, ", times %.0e", factor);
}

void flatten(Dice& dice, Pair& pair) {
  const Vec3 factors(1, dice.chance(0.5) ? dice.power(-12, 3) : 1, dice.power(-17, -2));
  for_each_position(pair, [&](Vec3& p) { p = p.cwiseProduct(factors); });
  note(pair, ", flattened by %.1e", factors.z());
}

// Scales some coordinates, or one mesh, by many orders of magnitude.
void mix_magnitudes(Dice& dice, Pair& pair) {
  const double factor = std::pow(10.0, dice.between(-300, 300));
  if (dice.chance(0.4)) {
    for (Vec3& p : pair.b.positions) p *= factor;
  } else {
    for_each_position(pair, [&](Vec3& p) {
      if (dice.chance(0.2)) p[dice.between(0, 2)] *= factor;
    });
  }
  note(pair, ", mixed with %.0e", factor);
}

void to_float(Pair& pair) {
  for_each_position(pair, [](Vec3& p) { p = p.cast<float>().cast<double>(); });
  pair.what += ", float32";
}

void nudge(Dice& dice, Pair& pair) {
  for_each_position(pair, [&](Vec3& p) { p = one_ulp_away(dice, p); });
  pair.what += ", nudged";
}

// Adds vertices that no triangle uses, with any coordinates.
void add_unreferenced(Dice& dice, Pair& pair) {
  static constexpr double kOdd[] = {0, 1e300, -1e308, std::numeric_limits<double>::infinity(),
                                    std::numeric_limits<double>::quiet_NaN()};
  for (Mesh* mesh : {&pair.a, &pair.b}) {
    const double x = dice.pick(kOdd), y = dice.pick(kOdd), z = dice.pick(kOdd);
    mesh->positions.emplace_back(x, y, z);
  }
  pair.what += ", unreferenced vertices";
}

void clamp(Pair& pair) {
  for_each_position(pair, [](Vec3& p) {
    for (int k = 0; k < 3; ++k) p[k] = std::isnan(p[k]) ? 0 : std::clamp(p[k], -kMaxCoordinate, kMaxCoordinate);
  });
}

// All kinds are equally frequent except the last, whose many triangles cost as much as ten other pairs.
const Kind& pick_kind(Dice& dice) {
  const auto all = kinds();
  if (dice.chance(0.01)) return all.back();
  return all[dice.below(static_cast<std::uint32_t>(all.size() - 1))];
}

}  // namespace

Pair generate(std::uint64_t seed) {
  Dice dice(seed);
  Pair pair;
  const Kind& kind = pick_kind(dice);
  pair.what = kind.name;
  kind.make(dice, pair);
  if (dice.chance(0.1)) flatten(dice, pair);
  if (dice.chance(0.3)) rotate(dice, pair);
  if (dice.chance(0.1)) to_float(pair);
  if (dice.chance(0.05)) nudge(dice, pair);
  if (dice.chance(0.08)) part(dice, pair);
  if (dice.chance(0.15)) offset(dice, pair);
  if (dice.chance(0.15)) scale(dice, pair);
  if (dice.chance(0.05)) mix_magnitudes(dice, pair);
  clamp(pair);
  if (dice.chance(0.05)) add_unreferenced(dice, pair);
  return pair;
}

void print_obj(const Mesh& mesh, const char* heading) {
  std::printf("--- %s\n", heading);
  for (const Vec3& p : mesh.positions) std::printf("v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
  for (const Triangle& t : mesh.triangles) std::printf("f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
}

}  // namespace meshgauge::fuzz
