// Kept meshes that are measured repeatedly, in any order and with any partner, give the same bits as fresh ones.
#include "engine/tree/prepared.h"

#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "fuzz/attack.h"
#include "fuzz/dice.h"
#include "same_outcome.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

constexpr int kRounds = MESHGAUGE_SANITIZED ? 15 : 150;
constexpr int kMeasurements = 40;  // in each round

// Meshes of all kinds, and the same meshes prepared.
struct Shelf {
  std::vector<Mesh> meshes;
  std::vector<std::unique_ptr<Prepared>> prepared;

  Shelf(std::uint64_t seed, Dice& dice) {
    for (std::uint64_t i = 0; i < 3; ++i) {
      const Pair pair = generate(seed + i);
      meshes.push_back(pair.a);
      meshes.push_back(pair.b);
    }
    for (const Mesh& mesh : meshes) {
      const auto use = dice.chance(0.8) ? Prepared::Use::often : Prepared::Use::once;
      prepared.push_back(std::make_unique<Prepared>(mesh, use));
    }
  }
};

Options random_options(Dice& dice) {
  Options options;
  options.strategy = methods()[dice.below(static_cast<std::uint32_t>(methods().size()))].strategy;
  options.points = dice.chance(0.5) ? 4 : 10;
  options.direction = static_cast<Direction>(dice.below(3));
  options.tolerance = {std::nullopt, dice.power(-9, -2), std::nullopt};
  options.max_work_items = 200;
  options.simd = supported_simd()[dice.below(static_cast<std::uint32_t>(supported_simd().size()))];
  return options;
}

}  // namespace

TEST_CASE("prepared meshes in any order and with any partner give the same bits as fresh ones") {
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t seed = 90'000 + 3 * static_cast<std::uint64_t>(round);
    CAPTURE(seed);
    Dice dice(seed);
    const Shelf shelf(seed, dice);
    for (int i = 0; i < kMeasurements; ++i) {
      const auto a = dice.below(static_cast<std::uint32_t>(shelf.meshes.size()));
      const auto b = dice.chance(0.7) ? a ^ 1U : dice.below(static_cast<std::uint32_t>(shelf.meshes.size()));
      const Options options = random_options(dice);
      Control alone, kept, cut;
      if (dice.chance(0.3)) {
        cut.cancel_at_check(1 + dice.below(30));
        (void)measure(*shelf.prepared[a], *shelf.prepared[b], options, cut);
      }
      CHECK(same_outcome(measure(*shelf.prepared[a], *shelf.prepared[b], options, kept),
                         measure(shelf.meshes[a], shelf.meshes[b], options, alone)));
    }
  }
}
