// Conversion to another unit against exact arithmetic: both surfaces times `over`, which avoids the quotient.
#include "engine/mesh/scaling.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "engine/hausdorff.h"
#include "engine/tree/prepared.h"
#include "oracle/farthest.h"

using namespace meshgauge;
using oracle::Dyadic;

namespace {

constexpr Factor kFactors[] = {{127, 5}, {5, 127}, {1000, 1}, {1, 1000}, {12, 1}, {1, 12}, {381, 1250}, {304800, 1}};

Dyadic square(const Dyadic& x) { return x * x; }

Mesh random_mesh(std::mt19937_64& bits, double size, double offset) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Mesh mesh;
  for (int i = 0; i < 5; ++i) {
    mesh.positions.emplace_back(offset + size * unit(bits), size * unit(bits), size * unit(bits));
  }
  for (std::uint32_t i = 0; i < 3; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  return mesh;
}

Mesh image_of(const Mesh& mesh, const Factor& factor) {
  auto image = scaled(mesh, factor);
  REQUIRE(image);
  return {std::move(image->positions), mesh.triangles};
}

// Checks by exact arithmetic that h(a times the factor, b) is in the interval: sqrt(known.lower_sq) <= over * h, and
// likewise above.
void check_interval(const Mesh& a, const Mesh& b, const Factor& factor, const Options& options) {
  const auto image = scaled(a, factor);
  REQUIRE(image);
  const Prepared of_a({image->positions, a.triangles}, Prepared::Use::once, nullptr, std::nullopt, image->error);
  Control control;
  const Outcome outcome = measure(of_a, Prepared(b), options, control);
  const auto from = oracle::times(oracle::surface_of(a), factor.times);
  const auto to = oracle::times(oracle::surface_of(b), factor.over);
  const Dyadic over = factor.over;
  const auto check = [&](const Bounds& bounds, const oracle::Bracket& exact) {
    CHECK(oracle::root_at_most(exact.lower_sq, over * Dyadic(bounds.upper)));
    CHECK(oracle::root_at_least(exact.upper_sq, over * Dyadic(bounds.lower)));
  };
  check(outcome.a_to_b->bounds, oracle::exact_bracket(from, to, 200));
  check(outcome.b_to_a->bounds, oracle::exact_bracket(to, from, 200));
  CHECK(outcome.precision_floor >= 2 * image->error);
}

Options tight() {
  Options options;
  options.tolerance = {0, std::nullopt, std::nullopt};
  options.max_work_items = 2000;
  return options;
}

}  // namespace

TEST_CASE("scaling: every coordinate is the nearest double if the product is exact") {
  const Mesh mesh{{{1, 2, 3}, {-0.5, 1000, 7}, {0, 0, 0}}, {{0, 1, 2}}};
  const auto inches = scaled(mesh, {127, 5});
  REQUIRE(inches);
  CHECK(inches->positions[0] == Vec3(25.4, 50.8, 76.2));
  CHECK(inches->positions[1] == Vec3(-12.7, 25400, 177.8));
  const auto metres = scaled(mesh, {1, 1000});
  REQUIRE(metres);
  CHECK(metres->positions[0] == Vec3(0.001, 0.002, 0.003));
}

TEST_CASE("scaling: no position is farther from its exact image than the error") {
  std::mt19937_64 bits(19);
  for (const double size : {1.0, 1e-310, 5e-324, 1e295}) {
    for (int i = 0; i < 50; ++i) {
      const Factor& factor = kFactors[static_cast<std::size_t>(i) % std::size(kFactors)];
      const Mesh mesh = random_mesh(bits, size, i % 2 == 0 ? 0 : 100 * size);
      const auto image = scaled(mesh, factor);
      REQUIRE(image);
      for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const oracle::Point off = Dyadic(factor.times) * oracle::exact(mesh.positions[v]) -
                                  Dyadic(factor.over) * oracle::exact(image->positions[v]);
        CHECK(dot(off, off) <= square(Dyadic(factor.over) * Dyadic(image->error)));
      }
    }
  }
}

TEST_CASE("scaling: a coordinate beyond kMaxCoordinate gives nullopt, unless no triangle uses it") {
  Mesh mesh{{{0x1p1010, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0x1p1010, 0, 0}}, {{0, 1, 2}}};
  CHECK(scaled(mesh, {1000, 1}).has_value());
  CHECK_FALSE(scaled(mesh, {304800, 1}).has_value());
  mesh.triangles[0] = {1, 2, 1};
  CHECK(scaled(mesh, {304800, 1}).has_value());
  CHECK_FALSE(scaled(mesh, {1, 1}, [] { return true; }).has_value());
}

TEST_CASE("scaling: the interval holds for the exact images") {
  std::mt19937_64 bits(7);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    const Factor& factor = kFactors[static_cast<std::size_t>(i) % std::size(kFactors)];
    const Mesh a = random_mesh(bits, 1, i % 3 == 0 ? 1000 : 0);
    Mesh b = random_mesh(bits, factor.times / factor.over, i % 3 == 0 ? 1000 * factor.times / factor.over : 0);
    Options options = tight();
    if (i % 4 == 0) options.strategy = Strategy::four_point;
    check_interval(a, b, factor, options);
  }
}

TEST_CASE("scaling: triangles that are equal after rounding are not at distance 0") {
  std::mt19937_64 bits(3);
  for (const Factor& factor : kFactors) {
    const Mesh a = random_mesh(bits, 1, 10);
    Mesh b = image_of(a, factor);
    check_interval(a, b, factor, tight());  // all shared
    b.positions[4] += Vec3(0.125, 0, 0);
    check_interval(a, b, factor, tight());  // some shared
  }
}

TEST_CASE("scaling: a limit within the error is undecided, a limit outside is decided") {
  const Mesh a{{{0.1, 0.2, 0.3}, {1.1, 0.7, 0.3}, {0.4, 1.3, 0.3}}, {{0, 1, 2}}};
  const Mesh b = image_of(a, {127, 5});
  const auto image = scaled(a, {127, 5});
  const Prepared of_a({image->positions, a.triangles}, Prepared::Use::once, nullptr, std::nullopt, image->error);
  Options options = tight();
  const auto upper = [&](double limit) {
    options.max_distance = limit;
    Control control;
    return measure(of_a, Prepared(b), options, control).upper;
  };
  CHECK(upper(0) > 0);
  CHECK(upper(image->error / 2) > image->error / 2);
  CHECK(upper(4 * image->error) <= 4 * image->error);
}

TEST_CASE("scaling: a gate near the distance is decided unless it is within the error") {
  const Mesh a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const Mesh b{{{0, 0, 1}, {25.4, 0, 1}, {0, 25.4, 1}}, {{0, 1, 2}}};
  const auto image = scaled(a, {127, 5});
  const Prepared of_a({image->positions, a.triangles}, Prepared::Use::once, nullptr, std::nullopt, image->error);
  const Prepared of_b(b);
  for (const Strategy strategy : {Strategy::automatic, Strategy::four_point}) {
    for (const double beside : {1e-12, 1e-3}) {
      Options options;
      options.strategy = strategy;
      options.tolerance = {std::nullopt, 1e-9, std::nullopt};
      Control control;
      options.max_distance = 1 + beside;
      CHECK(measure(of_a, of_b, options, control).upper <= *options.max_distance);
      options.max_distance = 1 - beside;
      CHECK(measure(of_a, of_b, options, control).lower > *options.max_distance);
    }
  }
}

TEST_CASE("scaling: an error of 0 changes no bit") {
  std::mt19937_64 bits(5);
  const Mesh a = random_mesh(bits, 1, 0), b = random_mesh(bits, 1, 0);
  Control control;
  const Outcome plain = measure(a, b, tight(), control);
  const Outcome prepared =
      measure(Prepared(a, Prepared::Use::once, nullptr, std::nullopt, 0), Prepared(b), tight(), control);
  CHECK(plain.lower == prepared.lower);
  CHECK(plain.upper == prepared.upper);
  CHECK(plain.precision_floor == prepared.precision_floor);
}
