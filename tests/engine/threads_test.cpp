// One job on several threads: the interval holds, converges and decides the gate as on one thread.
#include <doctest/doctest.h>

#include <cmath>

#include "engine/hausdorff.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

// A sphere with bumps of the given phase. Two phases lie near each other, so that there is much to bisect.
Mesh bumpy(std::uint32_t rings, double phase) {
  Mesh mesh = shapes::sphere(rings);
  for (Vec3& p : mesh.positions) {
    p *= 1 + 0.05 * std::sin(7 * p.x() + phase) * std::cos(5 * p.y()) * std::sin(6 * p.z() + phase);
  }
  return mesh;
}

struct Setup {
  Mesh a = bumpy(60, 0), b = bumpy(50, 0.05);
  Options options;

  Setup() {
    options.direction = Direction::a_to_b;
    options.tolerance = {std::nullopt, 1e-5, std::nullopt};
  }
  Outcome run(unsigned threads, Control& control) const {
    Options o = options;
    o.threads = threads;
    return measure(a, b, o, control);
  }
  Outcome run(unsigned threads) const {
    Control control;
    return run(threads, control);
  }
};

constexpr unsigned kThreads[] = {1, 2, 4};

}  // namespace

TEST_CASE("threads: the intervals of any number of threads meet and converge") {
  Setup setup;
  for (const Direction direction : {Direction::a_to_b, Direction::b_to_a, Direction::symmetric}) {
    setup.options.direction = direction;
    const Outcome one = setup.run(1);
    REQUIRE(one.stop == Stop::converged);
    for (const unsigned threads : kThreads) {
      const Outcome outcome = setup.run(threads);
      CHECK(outcome.stop == Stop::converged);
      CHECK(outcome.threads == threads);
      CHECK(outcome.lower <= one.upper);
      CHECK(one.lower <= outcome.upper);
    }
  }
}

// Few bounds but the twin's cull here, and each thread would have to find that out by itself.
TEST_CASE("threads: what attempts have shown is learnt once") {
  const auto torus = [](double phase, double shift) {
    constexpr std::uint32_t kAlong = 356, kAcross = kAlong / 2;
    Mesh mesh;
    for (std::uint32_t i = 0; i < kAlong * kAcross; ++i) {
      constexpr double kTurn = 6.283185307179586;
      const double u = kTurn * (i / kAcross + shift) / kAlong, v = kTurn * (i % kAcross + shift) / kAcross;
      const double radius = 0.4 * (1 + 0.05 * std::sin(7 * u + phase) * std::cos(5 * v));
      mesh.positions.emplace_back((1 + radius * std::cos(v)) * std::cos(u), (1 + radius * std::cos(v)) * std::sin(u),
                                  radius * std::sin(v));
      const auto at = [&](std::uint32_t x, std::uint32_t y) {
        return (i / kAcross + x) % kAlong * kAcross + (i + y) % kAcross;
      };
      mesh.triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
      mesh.triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
    return mesh;
  };
  Setup setup;
  setup.a = torus(0, 0);
  setup.b = torus(0.2, 0.5);
  setup.options.tolerance = {std::nullopt, 1e-4, std::nullopt};
  const std::size_t alone = setup.run(1).a_to_b->culling.survivors;
  CHECK(alone > 0);
  for (const unsigned threads : kThreads) CHECK(setup.run(threads).a_to_b->culling.survivors < alone + alone / 4);
}

TEST_CASE("threads: one thread gives the same bits every time, on every instruction set") {
  Setup setup;
  const Outcome first = setup.run(1);
  for (const std::string_view simd : supported_simd()) {
    setup.options.simd = simd;
    const Outcome again = setup.run(1);
    CHECK(again.simd == simd);
    CHECK(again.lower == first.lower);
    CHECK(again.upper == first.upper);
    CHECK(again.a_to_b->work.subdivisions == first.a_to_b->work.subdivisions);
    CHECK(again.a_to_b->work.triangle_tests == first.a_to_b->work.triangle_tests);
    CHECK(again.a_to_b->bounds.witness->point_a == first.a_to_b->bounds.witness->point_a);
  }
}

TEST_CASE("threads: the gate's verdict is the same on any number of threads") {
  Setup setup;
  const Outcome known = setup.run(1);
  for (const double factor : {0.5, 0.99, 1.01, 2.0}) {
    setup.options.max_distance = known.upper * factor;
    for (const unsigned threads : kThreads) {
      const Outcome outcome = setup.run(threads);
      CHECK((outcome.upper <= *setup.options.max_distance) == (factor > 1));
      CHECK((outcome.lower > *setup.options.max_distance) == (factor < 1));
    }
  }
}

TEST_CASE("threads: the interval holds after a cancellation at any check and after a spent budget") {
  Setup setup;
  const Outcome known = setup.run(1);
  for (const unsigned threads : kThreads) {
    for (std::uint64_t check = 1; check < 400; check += 1 + check / 3) {
      Control control;
      control.cancel_at_check(check);
      const Outcome outcome = setup.run(threads, control);
      CHECK(outcome.lower <= known.upper);
      CHECK(known.lower <= outcome.upper);
    }
    for (const std::uint64_t items : {0U, 1U, 100U, 1000U}) {
      setup.options.max_work_items = items;
      const Outcome outcome = setup.run(threads);
      CHECK(outcome.lower <= known.upper);
      CHECK(known.lower <= outcome.upper);
      CHECK(outcome.a_to_b->culling.survivors <= outcome.a_to_b->culling.triangles);
    }
    setup.options.max_work_items = Options{}.max_work_items;
  }
}

TEST_CASE("threads: every progress report has a valid interval") {
  const Setup setup;
  const Outcome known = setup.run(1);
  for (const unsigned threads : kThreads) {
    Control control;
    int reports = 0;
    control.watch(
        [&](const Progress& progress) {
          ++reports;
          CHECK(progress.lower <= known.upper);
          CHECK(known.lower <= progress.upper);
        },
        std::chrono::milliseconds(0));
    setup.run(threads, control);
    CHECK(reports > 0);
  }
}
