// The deviation of faces that are not planar, against all splits of a face: enumerated by exact orientations, measured
// by the engine with its certified intervals, and in part by the oracle's exact arithmetic.
#include "api/formats/polygons/polygon_deviation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "api/formats/polygons/polygons.h"
#include "engine/hausdorff.h"
#include "oracle/farthest.h"
#include "tests/api/formats/files.h"
#include "tests/fuzz/dice.h"
#include "tests/today.h"

namespace meshgauge::api::test {
namespace {

using fuzz::Dice;
using Split = std::vector<Triangle>;

Vec3 newell(const std::vector<Vec3>& corners) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  }
  return sum;
}

class Splits {
 public:
  explicit Splits(const std::vector<Vec3>& corners) : normal_(oracle::exact(newell(corners))) {
    for (const Vec3& p : corners) corners_.push_back(oracle::exact(p));
  }

  // All splits of the corners first..last: with the edge between the two, a triangle to each corner between them, seen
  // along the normal counter-clockwise. Triangles that all are cover a simple outline once.
  std::vector<Split> of(std::uint32_t first, std::uint32_t last) const {
    if (last - first < 2) return {{}};
    std::vector<Split> all;
    for (std::uint32_t middle = first + 1; middle < last; ++middle) {
      if (!is_left(first, middle, last)) continue;
      const std::vector<Split> left = of(first, middle), right = of(middle, last);
      for (const Split& l : left) {
        for (const Split& r : right) {
          Split split = l;
          split.insert(split.end(), r.begin(), r.end());
          split.push_back({first, middle, last});
          all.push_back(split);
        }
      }
    }
    return all;
  }

 private:
  bool is_left(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return dot(cross(corners_[b] - corners_[a], corners_[c] - corners_[a]), normal_).sign() > 0;
  }

  oracle::Point normal_;
  std::vector<oracle::Point> corners_;
};

struct Extreme {
  Mesh a;
  Mesh b;
  double lower = 0;
  double upper = 0;
};

Extreme extreme_of(const std::vector<Vec3>& corners, const std::vector<Split>& splits) {
  Options options;
  options.tolerance = {std::nullopt, 1e-12, 1e-3};
  Extreme extreme;
  for (std::size_t i = 0; i < splits.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Mesh a = {corners, splits[i]}, b = {corners, splits[j]};
      Control control;
      const Outcome outcome = measure(a, b, options, control);
      if (outcome.lower > extreme.lower) extreme = {a, b, outcome.lower, std::max(extreme.upper, outcome.upper)};
      extreme.upper = std::max(extreme.upper, outcome.upper);
    }
  }
  return extreme;
}

// A face about the origin, its corners lifted out of their plane by `height` at most, then turned and moved.
std::vector<Vec3> random_face(Dice& dice, int n, bool convex, double height) {
  const Eigen::Quaterniond turned(dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1));
  const Vec3 moved = dice.chance(0.5) ? dice.point(10) : Vec3(Vec3::Zero());
  const double size = dice.power(-3, 3), wide = dice.uniform(0.3, 1);
  std::vector<Vec3> corners;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + dice.uniform(0, 0.9)) / n;
    const double radius = convex ? 1 : dice.uniform(0.2, 1);
    const Vec3 p(radius * std::cos(angle), wide * radius * std::sin(angle), dice.uniform(-height, height));
    corners.push_back(size * (turned.normalized() * p + moved));
  }
  return corners;
}

Result<ReadMesh> read_off_face(const std::vector<Vec3>& corners) {
  std::string text = "OFF\n" + std::to_string(corners.size()) + " 1 0\n";
  for (const Vec3& p : corners) {
    char line[100];
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    text += line;
  }
  text += std::to_string(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) text += " " + std::to_string(i);
  return read(text, "m.off");
}

}  // namespace

TEST_CASE("deviation: for faces that are not planar, between once and twice what two splits are apart") {
  std::size_t apart = 0;
  for (const std::uint64_t seed : todays_part(10'000, 3)) {
    Dice dice(seed);
    const int n = seed % 100 == 0 ? 7 : (seed % 10 == 0 ? 6 : dice.between(4, 5));
    // Quads may be folded freely; the bound for other steep faces may exceed twice the deviation.
    const double height = dice.chance(0.5) ? dice.power(-4, -1) : dice.uniform(0.1, n == 4 ? 2 : 0.3);
    const std::vector<Vec3> corners = random_face(dice, n, dice.chance(0.6), height);
    const auto result = read_off_face(corners);
    REQUIRE(result.ok());
    const PolygonNotes& notes = result->notes.polygons;
    const std::vector<Split> splits = Splits(corners).of(0, static_cast<std::uint32_t>(n - 1));
    if (notes.self_crossing != 0 || splits.size() < 2) continue;
    ++apart;
    const Extreme extreme = extreme_of(corners, splits);
    const double reported = notes.largest_deviation;
    CAPTURE(seed);
    CAPTURE(n);
    CAPTURE(height);
    REQUIRE(reported >= extreme.lower);
    REQUIRE(reported <= 2 * extreme.upper);
    if (seed % 50 != 0) continue;
    const oracle::Surface a = oracle::surface_of(extreme.a), b = oracle::surface_of(extreme.b);
    const auto exact =
        std::max(oracle::farthest_sample(a, b, 200).distance_sq, oracle::farthest_sample(b, a, 200).distance_sq);
    REQUIRE(oracle::root_at_most(exact, reported));
    REQUIRE(oracle::root_at_least(exact, reported / 2));
  }
  CHECK(apart > 3'000);
}

TEST_CASE("deviation: known faces") {
  const auto notes_of = [](const std::vector<Vec3>& corners) {
    const auto result = read_off_face(corners);
    REQUIRE(result.ok());
    return result->notes.polygons;
  };
  const PolygonNotes warped = notes_of({{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0}, {0, 1, 0.1}});
  CHECK(warped.non_planar == 1);
  CHECK(warped.largest_deviation >= 0.1);
  CHECK(warped.largest_deviation < 0.1 + 1e-12);
  CHECK(notes_of({{0, 0, 7}, {1, 0, 7}, {1, 1, 7}, {0, 1, 7}}).largest_deviation == 0);
  // Not planar, but with only one split.
  const PolygonNotes dart = notes_of({{0, 0, 0}, {4, 0, 0}, {1, 1, 1}, {0, 4, 0}});
  CHECK(dart.concave == 1);
  CHECK(dart.non_planar == 1);
  CHECK(dart.largest_deviation == 0);
  // Corners on one line, as seen along the normal: no two diagonals cross, and yet two splits are 0.18 apart.
  CHECK(notes_of({{0, 0, 0}, {1, 0, 0.125}, {2, 0, -0.125}, {3, 0, 0}, {1.5, 1, 0}}).largest_deviation >= 0.18);
  // Rounding to binary32 does not make a face non-planar, but gives a deviation.
  const PolygonNotes rounded =
      notes_of({{0.1F, 0.2F, 0.3F}, {1.1F, 0.2F, 0.4F}, {1.1F, 1.2F, 0.5F}, {0.1F, 1.2F, 0.4F}});
  CHECK(rounded.non_planar == 0);
  CHECK(rounded.largest_deviation > 0);
  CHECK(rounded.largest_deviation < 1e-7);
}

TEST_CASE("deviation: large faces have the bound of their thickness") {
  std::vector<Vec3> corners;
  for (int i = 0; i < 200; ++i) {
    const double angle = 2 * std::numbers::pi * i / 200;
    corners.emplace_back(std::cos(angle), std::sin(angle), i % 2 == 0 ? 0.01 : -0.01);
  }
  const auto result = read_off_face(corners);
  REQUIRE(result.ok());
  CHECK(result->notes.polygons.largest_deviation >= 0.02 - 1e-12);
  CHECK(result->notes.polygons.largest_deviation < 0.021);
}

}  // namespace meshgauge::api::test
