// The limit of a measurement: when it is decided, and what is done after it.
#include <doctest/doctest.h>

#include "engine/hausdorff.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

Options within(double tolerance) {
  Options options;
  options.tolerance = {tolerance, std::nullopt, std::nullopt};
  options.direction = Direction::a_to_b;
  return options;
}

Outcome outcome_of(const Mesh& a, const Mesh& b, const Options& options) {
  const auto deadline = Control::Clock::now() + std::chrono::seconds(60);
  Control control(deadline);
  const Outcome outcome = measure(a, b, options, control);
  CHECK(outcome.lower <= outcome.upper);
  CHECK(control.deadline() == deadline);  // narrowing has one of its own, and gives this one back
  return outcome;
}

}  // namespace

TEST_CASE("the gate is decided as soon as the interval leaves it") {
  const Mesh a = shapes::sphere(24, 1), b = shapes::sphere(7, 1.1);
  const Outcome fine = outcome_of(a, b, within(1e-7));
  Options options = within(1e-9);
  options.max_distance = 2 * fine.upper;
  const Outcome pass = outcome_of(a, b, options);
  CHECK(pass.stop == Stop::gate_decided);
  CHECK(pass.upper <= *options.max_distance);
  options.max_distance = 0.5 * fine.lower;
  const Outcome fail = outcome_of(a, b, options);
  CHECK(fail.stop == Stop::gate_decided);
  CHECK(fail.lower > *options.max_distance);
}

TEST_CASE("a decided gate is narrowed to one percent of the distance when asked, with the same verdict") {
  const Mesh a = shapes::sphere(8, 1), b = shapes::sphere(5, 1.1);
  const Outcome fine = outcome_of(a, b, within(1e-7));
  for (const Strategy strategy : {Strategy::automatic, Strategy::four_point, Strategy::triangle_set}) {
    for (const double limit : {2 * fine.upper, 0.5 * fine.lower}) {
      Options options = within(1e-9);
      options.strategy = strategy;
      options.max_distance = limit;
      const Outcome decided = outcome_of(a, b, options);
      options.narrow = true;
      const Outcome narrow = outcome_of(a, b, options);
      CHECK(narrow.stop == Stop::gate_decided);
      CHECK(narrow.lower <= fine.upper);
      CHECK(narrow.upper >= fine.lower);
      CHECK(narrow.lower >= decided.lower);
      CHECK(narrow.upper <= decided.upper);
      CHECK((narrow.upper <= limit) == (decided.upper <= limit));
    }
  }
}

TEST_CASE("a decided gate is narrow at last, as often as a busy machine has too little time for it") {
  const Mesh a = shapes::sphere(8, 1), b = shapes::sphere(5, 1.1);
  const Outcome fine = outcome_of(a, b, within(1e-7));
  for (const double limit : {2 * fine.upper, 0.5 * fine.lower}) {
    Options options = within(1e-9);
    options.max_distance = limit;
    const Outcome decided = outcome_of(a, b, options);
    CHECK(decided.upper - decided.lower > 0.01 * decided.lower);
    options.narrow = true;
    Outcome narrow = outcome_of(a, b, options);
    while (narrow.upper - narrow.lower > 0.01 * narrow.lower) narrow = outcome_of(a, b, options);
    CHECK(narrow.stop == Stop::gate_decided);
  }
}

TEST_CASE("an uncertainty moves the limit both ways, and what it leaves open ends early") {
  const Mesh a = shapes::sphere(24, 1), b = shapes::sphere(7, 1.1);
  const Outcome fine = outcome_of(a, b, within(1e-7));
  const double u = 0.01;
  for (const double by : {-1.5, -0.5, 0.5, 1.5}) {
    CAPTURE(by);
    Options options = within(1e-9);
    options.max_distance = fine.upper - by * u;
    options.uncertainty = u;
    const double pass = *options.max_distance - u, fail = *options.max_distance + u;
    const Outcome decided = outcome_of(a, b, options);
    CHECK(decided.stop == Stop::gate_decided);
    CHECK((decided.upper <= pass) == (by < -1));
    CHECK((decided.lower > fail) == (by > 1));
    CHECK((decided.lower > pass && decided.upper <= fail) == (by > -1 && by < 1));
    CHECK(decided.lower <= fine.upper);
    CHECK(decided.upper >= fine.lower);
  }
}

TEST_CASE("a limit or a tolerance that is infinite in the frame gives the interval of a smaller one") {
  const double scale = 0x1p-1000;
  const Mesh a = shapes::scaled(shapes::grid(8), scale), b = shapes::moved(a, Vec3(0.01, 0.02, 0.3) * scale);
  Options options = within(1e-9 * scale);
  options.max_distance = 100 * scale;
  const Outcome known = outcome_of(a, b, options);
  options.max_distance = 1e20;
  CHECK(outcome_of(a, b, options).upper == known.upper);
  options = within(1e20);
  CHECK(outcome_of(a, b, options).upper == known.upper);
}
