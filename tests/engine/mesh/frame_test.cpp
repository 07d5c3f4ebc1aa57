#include "engine/mesh/frame.h"

#include <doctest/doctest.h>

#include <cmath>

#include "engine/rounding.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

Box box_of(const Vec3& low, const Vec3& high) {
  Box box;
  box.extend(low);
  box.extend(high);
  return box;
}

void check_frame(const Vec3& low, const Vec3& high) {
  const Frame frame(box_of(low, high));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  double largest = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = i == 0   ? low
                   : i == 1 ? high
                            : Vec3(low + uniform(random) * (high - low)).cwiseMin(high).cwiseMax(low);
    const Vec3 q = frame.to_frame(p);
    largest = std::max(largest, q.cwiseAbs().maxCoeff());
    CHECK(q.cwiseAbs().maxCoeff() < 1);
    CHECK(frame.from_frame(q) == p);  // the map is exact
  }
  CHECK(largest >= 0.5);
}

}  // namespace

TEST_CASE("the unit frame is exact, near and far, tiny and huge") {
  check_frame({-1, -2, -3}, {3, 2, 1});
  check_frame({1e6, 1e6, 1e6}, {1e6 + 1, 1e6 + 2, 1e6 + 1});
  check_frame({1e12, -1e12 - 3, 0}, {1e12 + 1, -1e12, 1});
  check_frame({0, 0, 0}, {1e-300, 2e-300, 1e-300});
  check_frame({0, 0, 0}, {5e-324, 1e-320, 0});
  check_frame({-0x1p1020, 0, 0}, {0x1p1020, 0x1p1000, 0});
  check_frame({1e300, 1e300, 1e300}, {1.5e300, 1.2e300, 1.1e300});
}

TEST_CASE("beside numbers 2^1000 times larger, small ones may lose bits far below the slack") {
  const Frame frame(box_of({-0x1p1020, 0, 0}, {0x1p1020, 1, 0}));
  CHECK(std::abs(frame.to_frame({0, 0.7, 0}).y() - std::ldexp(0.7, -1021)) <= 0x1p-1074);
}

TEST_CASE("a single point has a frame") {
  const Frame frame(box_of({3, 4, 5}, {3, 4, 5}));
  CHECK(frame.to_frame({3, 4, 5}) == Vec3::Zero());
  CHECK(frame.from_frame(Vec3::Zero()) == Vec3(3, 4, 5));
}

TEST_CASE("the unit frame is exact on thin axes and at every limit of a centre") {
  for (const double widest : {0.5, 0.8, 0.854, 0.8555, 0.99, 1.0, 1.3, 1.7, 1.75}) {
    for (const double thin : {0.0, 1e-9, 0.3}) {
      for (double low = 0.9; low < 6; low += 0.25 + low / 64) {
        check_frame({-low - widest, low, low + 0.01}, {-low, low + thin * widest, low + 0.01 + thin});
        check_frame({0, low, 1e9}, {widest, low + thin, 1e9 + thin});
      }
    }
  }
}

// A baseline and its candidates: the joint box is that of the baseline or a little larger.
TEST_CASE("boxes that differ by little have the same frame, near 0 and far away") {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const double off : {0.0, 5.0, 1000.0, 1e6, 1e9}) {
    int same = 0;
    constexpr int kPairs = 2000;
    for (int i = 0; i < kPairs; ++i) {
      const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
      const double size = std::exp2(8 * uniform(random));
      const Vec3 low = Vec3::Constant(off * size) + size * point(), high = low + size * (point() + Vec3::Constant(0.2));
      const Box box = box_of(low, high);
      Box more = box;
      more.extend(Vec3(low - 0.001 * size * point()));
      more.extend(Vec3(high + 0.001 * size * point()));
      same += Frame(box) == Frame(more) ? 1 : 0;
    }
    CHECK(same > kPairs * 0.98);
  }
  for (const double size : {0.25, 1.0, 2.0, 100.0}) {
    for (const double off : {0.0, 10.0, 1000.0, 1.5e6}) {
      const Vec3 low = Vec3::Constant(off), high = Vec3::Constant(off + size);
      const Box more = box_of(low - Vec3::Constant(1e-3 * size), high + Vec3::Constant(1e-3 * size));
      CHECK(Frame(box_of(low, high)) == Frame(more));
    }
  }
}

TEST_CASE("lengths are scaled outwards") {
  const double tiny = 5e-324;
  CHECK(rounding::scale_up(1.0, -1080) == tiny);
  CHECK(rounding::scale_down(1.0, -1080) == 0);
  CHECK(rounding::scale_up(0.0, -1080) == 0);
  CHECK(rounding::scale_up(0.75, 3) == 6);
  CHECK(rounding::scale_down(0.75, 3) == 6);
  CHECK(rounding::scale_up(0x1.0000000000001p-1, -1060) > 0x1p-1061);
  CHECK(rounding::add_up(1, 0x1p-60) > 1);
  CHECK(rounding::subtract_down(1, 0x1p-60) < 1);
  CHECK(rounding::subtract_down(1, 2) == 0);
}
