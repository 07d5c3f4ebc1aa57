// Compares every instruction set with the reference, bit by bit, and the reference with the plain functions.
#include "engine/kernels/kernels.h"
#include "engine/kernels/flat.h"

#include <doctest/doctest.h>

#include <bit>
#include <cstring>

#include "engine/rounding.h"
#include "engine/tree/nearest.h"
#include "shapes.h"
#include "tree.h"

using namespace meshgauge;

namespace {

constexpr int kRounds = 3000;

// Points and triangles of every difficult kind: slivers, segments, points, tiny, equal corners, far corners.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  double coordinate() {
    switch (random_() % 8) {
      case 0:
        return 0;
      case 1:
        return 1;
      case 2:
        return std::ldexp(uniform_(random_), -static_cast<int>(random_() % 1000));
      default:
        return uniform_(random_);
    }
  }
  PointBlock points() {
    PointBlock block;
    for (auto& axis : block.at) {
      for (double& x : axis) x = coordinate();
    }
    return block;
  }
  std::array<PointBlock, 3> triangles() {
    std::array<PointBlock, 3> corners{points(), points(), points()};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const auto copy = [&](std::size_t to, double blend) {
        for (int k = 0; k < 3; ++k) {
          corners[to].at[k][lane] = corners[0].at[k][lane] + blend * (corners[1].at[k][lane] - corners[0].at[k][lane]);
        }
      };
      switch (random_() % 6) {
        case 0:
          copy(2, 0.25);  // a sliver, as flat as rounding allows
          break;
        case 1:
          copy(2, 0);  // a segment
          break;
        case 2:
          copy(1, 0), copy(2, 0);  // a point
          break;
        default:
          break;
      }
    }
    return corners;
  }

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

const Kernels& reference() { return *find_kernels("scalar"); }

Vec3 point(const PointBlock& block, std::size_t lane) {
  return {block.at[0][lane], block.at[1][lane], block.at[2][lane]};
}

}  // namespace

TEST_CASE("the list of instruction sets ends with the reference, and each is found by its name") {
  const auto all = supported_kernels();
  REQUIRE_FALSE(all.empty());
  CHECK(std::string_view(all.back().name) == "scalar");
  for (const Kernels& kernels : all) CHECK(find_kernels(kernels.name) == &kernels);
  CHECK(find_kernels("auto") == &all.front());
  CHECK(find_kernels("abacus") == nullptr);
}

TEST_CASE("prepare: the same bits on every set, within the residual of the corners") {
  Dice dice(61);
  for (int round = 0; round < kRounds; ++round) {
    const auto corners = dice.triangles();
    TriangleBlock expected{};
    const double residual = reference().prepare(corners.data(), expected);
    for (const Kernels& kernels : supported_kernels()) {
      TriangleBlock block{};
      REQUIRE(same_bits(kernels.prepare(corners.data(), block), residual));
      REQUIRE(same_bits(block, expected));
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Preparation one = prepare(point(corners[0], lane), point(corners[1], lane), point(corners[2], lane));
      CHECK(one.residual <= residual + 2 * rounding::kResidualSlack + 8 * rounding::kUnit);
      CHECK(expected.length[lane] == doctest::Approx(one.triangle.length).epsilon(1e-14));
      CHECK(std::abs(expected.cy[lane] - one.triangle.cy) < 1e-15);
    }
  }
}

TEST_CASE("nearest: the same triangle and bits on every set, with and without a hint, and where near is enough") {
  std::mt19937_64 random(63);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Mesh& mesh : {shapes::sphere(30, 0.8), shapes::soup(2000, random), shapes::cube(0.5)}) {
    const Bvh tree = tree_of(mesh);
    for (int i = 0; i < 500; ++i) {
      Vec3 p(uniform(random), uniform(random), uniform(random));
      if (i % 4 == 0) p = mesh.positions[random() % mesh.positions.size()];
      const auto hint = static_cast<std::uint32_t>(random() % mesh.triangles.size());
      const double hint_sq = (p - closest_point(tree.prepared(hint), p)).squaredNorm();
      for (const Closest start :
           {Closest{std::numeric_limits<double>::infinity(), Nearest::kNone}, Closest{hint_sq, hint}}) {
        std::uint64_t expected_tests = 0;
        Polling polling(nullptr, 0, i % 2 == 0 ? 0 : uniform(random));
        const Closest expected = reference().nearest(tree.view(), p.data(), start, expected_tests, polling);
        for (const Kernels& kernels : supported_kernels()) {
          std::uint64_t tests = 0;
          const Closest found = kernels.nearest(tree.view(), p.data(), start, tests, polling);
          REQUIRE(found.slot == expected.slot);
          REQUIRE(same_bits(found.distance_sq, expected.distance_sq));
          REQUIRE(tests == expected_tests);
        }
      }
    }
  }
}

TEST_CASE("lower: the same lanes and bits on every set, and none is left out that may lower") {
  Dice dice(67);
  std::size_t left_out = 0;
  for (int round = 0; round < kRounds; ++round) {
    const auto corners = dice.triangles();
    PointBlock low = corners[0], high = corners[0];
    LowerProbe probe{};
    for (int k = 0; k < 3; ++k) {
      probe.centre[k] = dice.coordinate();
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        low.at[k][lane] = std::min({corners[0].at[k][lane], corners[1].at[k][lane], corners[2].at[k][lane]});
        high.at[k][lane] = std::max({corners[0].at[k][lane], corners[1].at[k][lane], corners[2].at[k][lane]});
      }
    }
    probe.limit_sq = std::abs(dice.coordinate());
    probe.directions = static_cast<std::size_t>(round) % (LowerProbe::kMaxDirections + 1);
    for (std::size_t d = 0; d < probe.directions; ++d) {
      probe.tops[d] = dice.coordinate();
      for (double& n : probe.n[d]) n = dice.coordinate();
    }
    alignas(64) double expected_sq[kLanes];
    const unsigned boxes = reference().lower_boxes(low, high, probe, expected_sq);
    const unsigned triangles = reference().lower_triangles(corners.data(), probe);
    for (const Kernels& kernels : supported_kernels()) {
      alignas(64) double distances_sq[kLanes];
      REQUIRE(kernels.lower_boxes(low, high, probe, distances_sq) == boxes);
      REQUIRE(same_bits(distances_sq, expected_sq));
      REQUIRE(kernels.lower_triangles(corners.data(), probe) == triangles);
    }
    const Vec3 centre(probe.centre[0], probe.centre[1], probe.centre[2]);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const Vec3 off = (point(low, lane) - centre).cwiseMax(centre - point(high, lane)).cwiseMax(0.0);
      bool may = off.squaredNorm() <= probe.limit_sq;
      for (std::size_t d = 0; d < probe.directions; ++d) {
        double top = -1e300;
        for (const PointBlock& corner : corners)
          top = std::max(top, Vec3(probe.n[d][0], probe.n[d][1], probe.n[d][2]).dot(point(corner, lane)));
        may = may && top > probe.tops[d] + 1e-14;
      }
      if (may) CHECK((triangles & boxes & (1U << lane)) != 0);
      left_out += (triangles & (1U << lane)) == 0 ? 1U : 0U;
    }
  }
  CHECK(left_out > kRounds);
}

TEST_CASE("farthest: the same bits on every set, and the distances of the closest points") {
  Dice dice(64);
  std::mt19937_64 random(65);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < kRounds; ++round) {
    const auto corners = dice.triangles();
    TriangleBlock block{};
    reference().prepare(corners.data(), block);
    PointBlock points{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      for (int k = 0; k < 3; ++k) {
        points.at[k][lane] = lane < kLanes / 2 ? uniform(random) : points.at[k][lane - kLanes / 2];
        if (round % 4 == 0 && lane == 1) points.at[k][lane] = corners[1].at[k][lane];
      }
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double expected = reference().farthest_sq(block, lane, points);
      for (const Kernels& kernels : supported_kernels()) {
        REQUIRE(same_bits(kernels.farthest_sq(block, lane, points), expected));
      }
      const FlatTriangle f = flat(block, lane);
      const PreparedTriangle t{Vec3(f.a[0], f.a[1], f.a[2]),
                               Vec3(f.e1[0], f.e1[1], f.e1[2]),
                               Vec3(f.e2[0], f.e2[1], f.e2[2]),
                               f.length,
                               f.cx,
                               f.cy};
      double farthest = 0;
      for (std::size_t i = 0; i < kLanes / 2; ++i) {
        const Vec3 p = point(points, i);
        farthest = std::max(farthest, (p - closest_point(t, p)).norm());
      }
      CHECK(std::abs(std::sqrt(expected) - farthest) <= rounding::kDistanceSlack);
    }
  }
}
