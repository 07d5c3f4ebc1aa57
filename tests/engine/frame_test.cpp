#include "engine/frame.h"

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
    CHECK(frame.from_frame(q) == p);  // the map loses nothing
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
