// With lowered thresholds small meshes reach the bounds that are meant for large ones, and the oracle accepts every
// interval.
#include <doctest/doctest.h>

#include "fuzz/attack.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

Attempt attempt_with(Dice& dice, const Thresholds& thresholds) {
  Attempt attempt;
  attempt.options.tolerance = {std::nullopt, dice.power(-6, 0), std::nullopt};
  attempt.options.max_work_items = 250;
  attempt.options.thresholds = thresholds;
  return attempt;
}

bool same_work(const Outcome& a, const Outcome& b) {
  return a.a_to_b->work.triangle_tests == b.a_to_b->work.triangle_tests &&
         a.b_to_a->work.triangle_tests == b.b_to_a->work.triangle_tests;
}

// Measures pairs with some triangles, judges them with `lowered`, and returns how many do other work than with `usual`.
int pairs_changed(std::uint64_t first_seed, const Thresholds& usual, const Thresholds& lowered) {
  int changed = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + 1500; ++seed) {
    const Pair pair = generate(seed);
    if (pair.a.triangles.size() < 16) continue;
    Dice dice(seed);
    Attempt attempt = attempt_with(dice, lowered);
    oracle::Judge judge(pair.a, pair.b, {});
    const Attacked attacked = attack(pair, attempt, judge);
    if (attacked.violation) {
      FAIL_CHECK("pair ", seed, ", ", pair.what, ": ", attacked.violation->check, ": ", attacked.violation->detail);
    }
    attempt.options.thresholds = usual;
    if (!same_work(attacked.seen.outcome, run(pair, attempt).outcome)) ++changed;
  }
  return changed;
}

}  // namespace

TEST_CASE("small pairs reach the patch certificate, and the intervals hold") {
  Thresholds without, with;
  without.block = with.block = 4;
  with.patches = 0, with.triangles_a_patch = 1, with.patch_group = 1;
  CHECK(pairs_changed(300'000, without, with) > 10);
}

TEST_CASE("the intervals hold with all thresholds lowered") {
  Dice dice(1);
  CHECK(pairs_changed(500'000, {}, lowered_thresholds(dice)) > 10);
}
