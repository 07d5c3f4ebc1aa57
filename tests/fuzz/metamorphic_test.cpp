// Changes that must not change the distance: position, unit, which mesh comes first, the order of triangles and
// vertices, splitting of triangles. Intervals of equal distances must meet.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "engine/hausdorff.h"
#include "fuzz/attack.h"
#include "fuzz/dice.h"
#include "today.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

constexpr std::uint64_t kPairs = MESHGAUGE_SANITIZED ? 150 : 600;  // half of them each day

Outcome measure_with(const Method& method, const Mesh& a, const Mesh& b, Direction direction) {
  Options options;
  options.strategy = method.strategy;
  options.direction = direction;
  options.tolerance = {std::nullopt, 1e-9, std::nullopt};
  options.max_work_items = 300;
  Control control;
  return measure(a, b, options, control);
}

// The largest |coordinate| of all positions, used or not; a position that is not finite counts as 0.
double magnitude(const Pair& pair) {
  double largest = 0;
  for (const Mesh* mesh : {&pair.a, &pair.b}) {
    for (const Vec3& p : mesh->positions) largest = std::max(largest, p.allFinite() ? p.cwiseAbs().maxCoeff() : 0);
  }
  return largest;
}

void check_meet(const Outcome& one, const Outcome& other, double slack) {
  CHECK(one.lower <= other.upper + slack);
  CHECK(other.lower <= one.upper + slack);
}

template <class Change>
Mesh changed(Mesh mesh, Change&& change) {
  for (Vec3& p : mesh.positions) p = change(p);
  return mesh;
}

// For each pair of moderate size, each method and each direction: compares the outcome with that of the changed pair,
// whose points may have moved by `roundings` units in the last place.
template <class Change>
void check_invariance(std::uint64_t seed, double roundings, Change&& change) {
  for (const std::uint64_t i : todays_part(kPairs, 2)) {
    const Pair pair = generate(seed + i);
    const double size = magnitude(pair);
    if (!(size < 1e100 && size > 1e-100)) continue;
    CAPTURE(seed + i);
    Dice dice(i);
    const Pair other = change(pair, dice);
    for (const Method& method : methods()) {
      for (const Direction direction : {Direction::symmetric, Direction::a_to_b, Direction::b_to_a}) {
        CAPTURE(std::string(method.name));
        check_meet(measure_with(method, pair.a, pair.b, direction), measure_with(method, other.a, other.b, direction),
                   roundings * 0x1p-52 * size);
      }
    }
  }
}

bool same_after_scaling(const Witness& a, const Witness& b, double factor) {
  return a.point_a * factor == b.point_a && a.point_b * factor == b.point_b && a.triangle_a == b.triangle_a &&
         a.triangle_b == b.triangle_b;
}

bool same_after_scaling(const Directed& one, const Directed& scaled, double factor) {
  const Bounds &a = one.bounds, &b = scaled.bounds;
  return a.lower * factor == b.lower && a.upper * factor == b.upper && a.witness.has_value() == b.witness.has_value() &&
         (!a.witness || same_after_scaling(*a.witness, *b.witness, factor)) &&
         one.work.subdivisions == scaled.work.subdivisions;
}

Mesh shuffled(const Mesh& mesh, Dice& dice) {
  std::vector<std::uint32_t> place(mesh.positions.size());
  std::iota(place.begin(), place.end(), 0U);
  const auto shuffle = [&](auto& items) {
    for (std::size_t i = items.size(); i > 1; --i) {
      std::swap(items[i - 1], items[dice.below(static_cast<std::uint32_t>(i))]);
    }
  };
  shuffle(place);
  Mesh out = mesh;
  for (std::size_t i = 0; i < place.size(); ++i) out.positions[place[i]] = mesh.positions[i];
  for (Triangle& t : out.triangles) {
    for (std::uint32_t& v : t) v = place[v];
    std::rotate(t.begin(), t.begin() + dice.below(3), t.end());
    if (dice.chance(0.5)) std::swap(t[0], t[1]);
  }
  shuffle(out.triangles);
  return out;
}

// Splits every triangle in four at its rounded midpoints.
Mesh split(const Mesh& mesh) {
  Mesh out;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const auto n = static_cast<std::uint32_t>(out.positions.size());
    out.positions.insert(out.positions.end(), {a, b, c, (a + b) / 2, (b + c) / 2, (c + a) / 2});
    out.triangles.insert(out.triangles.end(),
                         {{n, n + 3, n + 5}, {n + 3, n + 1, n + 4}, {n + 5, n + 4, n + 2}, {n + 3, n + 4, n + 5}});
  }
  return out;
}

}  // namespace

TEST_CASE("invariance: scaling by a power of two gives the same bits after scaling back") {
  std::uint64_t compared = 0;
  for (const std::uint64_t i : todays_part(kPairs, 2)) {
    const Pair pair = generate(70'000 + i);
    const double size = magnitude(pair);
    if (!(size < 1e15 && size > 1e-3)) continue;
    CAPTURE(70'000 + i);
    for (const double factor : {0x1p-60, 0x1p1, 0x1p300}) {
      const auto scale = [&](const Vec3& p) -> Vec3 { return p * factor; };
      const Mesh a = changed(pair.a, scale), b = changed(pair.b, scale);
      for (const Method& method : methods()) {
        CAPTURE(std::string(method.name));
        const Outcome one = measure_with(method, pair.a, pair.b, Direction::symmetric);
        const Outcome other = measure_with(method, a, b, Direction::symmetric);
        CHECK(one.lower * factor == other.lower);
        CHECK(one.upper * factor == other.upper);
        CHECK(one.precision_floor * factor == other.precision_floor);
        CHECK(one.stop == other.stop);
        CHECK(same_after_scaling(*one.a_to_b, *other.a_to_b, factor));
        CHECK(same_after_scaling(*one.b_to_a, *other.b_to_a, factor));
        ++compared;
      }
    }
  }
  CHECK(compared > 5 * kPairs / 2);
}

TEST_CASE("invariance: reflections and exchanges of axes, which are exact") {
  check_invariance(71'000, 0, [](const Pair& pair, Dice& dice) {
    const int shift = dice.between(0, 2);
    const Vec3 signs(dice.sign(), dice.sign(), dice.sign());
    const auto turn = [&](const Vec3& p) -> Vec3 {
      return Vec3(p[shift], p[(shift + 1) % 3], p[(shift + 2) % 3]).cwiseProduct(signs);
    };
    return Pair{changed(pair.a, turn), changed(pair.b, turn), pair.what};
  });
}

TEST_CASE("invariance: rotations and translations, which round") {
  check_invariance(72'000, 64, [](const Pair& pair, Dice& dice) {
    const Eigen::AngleAxisd turn(dice.uniform(0, 6), (dice.point() + Vec3(0, 0, 2)).normalized());
    const Vec3 shift = dice.point(magnitude(pair));
    const auto move = [&](const Vec3& p) -> Vec3 { return turn * p + shift; };
    return Pair{changed(pair.a, move), changed(pair.b, move), pair.what};
  });
}

TEST_CASE("invariance: the order of triangles, of vertices, and of a triangle's corners") {
  check_invariance(73'000, 0, [](const Pair& pair, Dice& dice) {
    const Mesh a = shuffled(pair.a, dice);
    return Pair{a, shuffled(pair.b, dice), pair.what};
  });
}

TEST_CASE("invariance: triangles split in four") {
  check_invariance(74'000, 4, [](const Pair& pair, Dice& dice) {
    return Pair{dice.chance(0.7) ? split(pair.a) : pair.a, dice.chance(0.7) ? split(pair.b) : pair.b, pair.what};
  });
}

TEST_CASE("invariance: A and B swapped, and all strategies on one pair") {
  for (const std::uint64_t i : todays_part(kPairs, 2)) {
    CAPTURE(75'000 + i);
    const Pair pair = generate(75'000 + i);
    std::vector<Outcome> symmetric, directed;
    for (const Method& method : methods()) {
      symmetric.push_back(measure_with(method, pair.a, pair.b, Direction::symmetric));
      symmetric.push_back(measure_with(method, pair.b, pair.a, Direction::symmetric));
      directed.push_back(measure_with(method, pair.a, pair.b, Direction::a_to_b));
      directed.push_back(measure_with(method, pair.b, pair.a, Direction::b_to_a));
    }
    for (const auto* outcomes : {&symmetric, &directed}) {
      for (const Outcome& one : *outcomes) {
        for (const Outcome& other : *outcomes) CHECK(one.lower <= other.upper);
      }
    }
  }
}
