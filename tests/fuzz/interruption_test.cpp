// The interval holds after an interruption at any moment.
#include <doctest/doctest.h>

#include <algorithm>

#include "fuzz/attack.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

Attempt attempt_with(const Method& method) {
  Attempt attempt;
  attempt.options.strategy = method.strategy;
  attempt.options.tolerance = {std::nullopt, 1e-9, std::nullopt};
  attempt.options.max_work_items = 60;
  return attempt;
}

}  // namespace

TEST_CASE("the interval holds after a cancellation at every single check") {
  std::uint64_t interruptions = 0;
  for (std::uint64_t seed = 80'000; seed < 80'060; ++seed) {
    const Pair pair = generate(seed);
    oracle::Judge judge(pair.a, pair.b, {});
    for (const Method& method : methods()) {
      Attempt attempt = attempt_with(method);
      const std::uint64_t checks = std::min<std::uint64_t>(run(pair, attempt).checks, 300);
      for (std::uint64_t k = 1; k <= checks; ++k) {
        attempt.cancel_at = k;
        const Attacked attacked = attack(pair, attempt, judge);
        if (!attacked.violation) continue;
        FAIL_CHECK("pair ", seed, ", ", method.name, ", check ", k, ": ", attacked.violation->check, ": ",
                   attacked.violation->detail);
      }
      interruptions += checks;
    }
  }
  CHECK(interruptions > 5000);
}
