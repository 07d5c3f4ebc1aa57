#include "check/html/strip.h"

#include <cmath>
#include <cstdlib>
#include <optional>

#include <doctest/doctest.h>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

// Two squares side by side as seen from above: the candidate on the left, the baseline on the right, with a common part
// in the middle.
struct Squares {
  Mesh candidate = shapes::grid(1, 2);
  Mesh baseline = shapes::moved(shapes::grid(1, 2), Vec3(1, 0, 0));
  Box box = bounding_box(shapes::joined(candidate, baseline));

  StripScene scene(double distance) const {
    const MeshView both[] = {candidate, baseline};
    const Camera camera = common_view(both, Frame(box), View{}, {}, kStripViewWidth, kStripViewHeight);
    const auto same = [distance](const Vec3&) { return distance; };
    return {{candidate, same}, {baseline, same}, camera, {1, true}, std::nullopt};
  }
};

// A pixel of the view `index`, 0 to 2.
Pixel pixel_at(const Image& strip, const StripScene& scene, int index, const Vec3& point) {
  const Seen seen = scene.camera.see(point);
  const int left = (strip.width - 3 * kStripViewWidth) / 4;
  const int x = left + index * (kStripViewWidth + left) + static_cast<int>(seen.x);
  const int y = strip.height - left - kStripViewHeight + static_cast<int>(seen.y);
  const std::size_t at = strip.at(x, y);
  return {strip.rgba[at], strip.rgba[at + 1], strip.rgba[at + 2], strip.rgba[at + 3]};
}

bool is_white(const Pixel& p) { return p[0] > 250 && p[1] > 250 && p[2] > 250; }
bool is_red(const Pixel& p) { return p[0] > p[1] + 40 && p[0] > p[2] + 30; }
bool is_grey(const Pixel& p) { return !is_white(p) && std::abs(p[0] - p[1]) < 24 && std::abs(p[1] - p[2]) < 24; }

const Vec3 kLeft(0.5, 1, 0), kMiddle(1.5, 1, 0), kRight(2.5, 1, 0);

}  // namespace

TEST_CASE("before is the baseline, after the candidate, and the difference has both") {
  const Squares squares;
  const StripScene scene = squares.scene(0.5);
  ThreadPool pool(1);
  const Image strip = strip_of(scene, pool);
  CHECK(is_white(pixel_at(strip, scene, 0, kLeft)));
  CHECK(is_grey(pixel_at(strip, scene, 0, kRight)));
  CHECK(is_grey(pixel_at(strip, scene, 1, kLeft)));
  CHECK(is_white(pixel_at(strip, scene, 1, kRight)));
  for (const Vec3& point : {kLeft, kMiddle, kRight}) {
    CHECK_FALSE(is_white(pixel_at(strip, scene, 2, point)));
    CHECK_FALSE(is_grey(pixel_at(strip, scene, 2, point)));
  }
  // What only the baseline has is translucent.
  CHECK(pixel_at(strip, scene, 2, kRight)[2] > pixel_at(strip, scene, 2, kLeft)[2]);
}

TEST_CASE("above the limit is red, and what is not measured stays grey") {
  const Squares squares;
  StripScene scene = squares.scene(2);
  scene.baseline.distance = nullptr;
  ThreadPool pool(1);
  const auto reds = [&](const Image& strip, const Vec3& point) {
    int count = 0;  // hatched: some pixels around are light
    for (int i = -10; i <= 10; ++i) count += is_red(pixel_at(strip, scene, 2, point + Vec3(0.01 * i, 0, 0))) ? 1 : 0;
    return count;
  };
  const Image forwards = strip_of(scene, pool);
  CHECK(reds(forwards, kLeft) > 8);
  CHECK(reds(forwards, kMiddle) > 8);
  CHECK(is_grey(pixel_at(forwards, scene, 2, kRight)));
  scene = squares.scene(2);
  scene.candidate.distance = nullptr;
  const Image backwards = strip_of(scene, pool);
  CHECK(is_grey(pixel_at(backwards, scene, 2, kLeft)));
  CHECK(reds(backwards, kMiddle) > 8);
  CHECK(reds(backwards, kRight) > 8);
}

TEST_CASE("the failing point is marked in the difference alone") {
  const Squares squares;
  StripScene scene = squares.scene(0.5);
  ThreadPool pool(1);
  const Image plain = strip_of(scene, pool);
  scene.mark = scene.camera.see(kMiddle);
  const Image marked = strip_of(scene, pool);
  const int last = plain.width - kStripViewWidth - 20;
  int left = 0, right = 0;
  for (int y = 0; y < plain.height; ++y) {
    for (int x = 0; x < plain.width; ++x) {
      if (plain.rgba[plain.at(x, y)] != marked.rgba[plain.at(x, y)]) (x < last ? left : right)++;
    }
  }
  CHECK(left == 0);
  CHECK(right > 60);
}

TEST_CASE("a strip has the same bits on any number of threads") {
  const Mesh round = shapes::sphere(20), larger = shapes::sphere(14, 1.1);
  const MeshView both[] = {round, larger};
  const Frame frame(bounding_box(larger));
  const auto height = [](const Vec3& p) { return std::abs(p.z()); };
  const StripScene scene{{round, height},
                         {larger, height},
                         common_view(both, frame, View{}, {}, kStripViewWidth, kStripViewHeight),
                         {0.5, true},
                         Seen{100, 100, 0}};
  ThreadPool one(1), several(3);
  const Image strip = strip_of(scene, one);
  CHECK(strip.rgba == strip_of(scene, several).rgba);
  CHECK(to_png_within(strip, kStripBytes).size() <= kStripBytes);
}
