// Results to the last bit. They are the same with every compiler, standard library, instruction set and machine
// (docs/design.md section 8). A change of the engine that changes them belongs into CHANGELOG.md.
#include <cmath>
#include <cstdint>
#include <random>

#include <doctest/doctest.h>

#include "engine/hausdorff.h"

using namespace meshgauge;

namespace {

// Heights over a square of 20 x 20, of numbers that are the same everywhere: a distribution of the library need not be.
Mesh terrain(std::uint64_t seed, std::uint32_t side) {
  std::mt19937_64 bits(seed);
  const auto number = [&bits] { return std::ldexp(static_cast<double>(bits() >> 11), -53); };
  const double step = 20.0 / side;
  Mesh mesh;
  for (std::uint32_t i = 0; i <= side; ++i) {
    for (std::uint32_t k = 0; k <= side; ++k) {
      const double x = i * step + number() / 4, y = k * step + number() / 4;
      mesh.positions.emplace_back(x, y, number());
      const std::uint32_t v = i * (side + 1) + k;
      if (i == side || k == side) continue;
      mesh.triangles.push_back({v, v + 1, v + side + 1});
      mesh.triangles.push_back({v + 1, v + side + 2, v + side + 1});
    }
  }
  return mesh;
}

Outcome measured(Strategy strategy, double tolerance, bool areas = false) {
  Options options;
  options.strategy = strategy;
  options.tolerance = {tolerance, std::nullopt, std::nullopt};
  options.points = 10;
  options.max_work_items = 20'000;
  if (areas) options.areas = AreaOptions{{{0.1, std::nullopt}}, {0.5}, true};
  Control control;
  return measure(terrain(1, 20), terrain(2, 10), options, control);
}

}  // namespace

TEST_CASE("bits: intervals and witnesses") {
  struct Expected {
    Strategy strategy;
    double tolerance;
    double upper;
    std::uint32_t triangle;
  };
  for (const Expected& expected : {Expected{Strategy::automatic, 1e-6, 0x1.b28ac71d28812p-1, 518},
                                   Expected{Strategy::four_point, 1e-3, 0x1.b28ac71d278d2p-1, 519},
                                   Expected{Strategy::n_point, 1e-3, 0x1.b28ac71d27892p-1, 519},
                                   Expected{Strategy::triangle_set, 1e-2, 0x1.b28ac71d27892p-1, 519}}) {
    const Outcome outcome = measured(expected.strategy, expected.tolerance);
    CAPTURE(static_cast<int>(expected.strategy));
    CHECK(outcome.lower == 0x1.b28ac71d269fp-1);
    CHECK(outcome.upper == expected.upper);
    REQUIRE(outcome.a_to_b->bounds.witness);
    const Witness& witness = *outcome.a_to_b->bounds.witness;
    CHECK(witness.point_a == Vec3(0x1.833f23555aa65p+3, 0x1.437c571684021p+4, 0x1.a97ca53106b4p-4));
    CHECK(witness.triangle_a == expected.triangle);
    CHECK(witness.triangle_b == 119);
  }
}

TEST_CASE("bits: areas") {
  const Outcome outcome = measured(Strategy::automatic, 1e-3, true);
  const AreaBounds& areas = *outcome.areas->a_to_b;
  CHECK(areas.beyond[0].lower == 0x1.7c7f1fb5dd92cp-1);
  CHECK(areas.beyond[0].upper == 0x1.7d00f4a056046p-1);
  CHECK(areas.quantiles[0].lower == 0x1.9f406806c805cp-3);
  CHECK(areas.mean->lower == 0x1.c9d3ba515b0abp-3);
  CHECK(areas.mean->upper == 0x1.ce5a5fbd3f446p-3);
  CHECK(areas.rms->upper == 0x1.17cfd0135a5e4p-2);
}
