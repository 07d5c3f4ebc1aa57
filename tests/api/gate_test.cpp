#include "api/gate.h"

#include <doctest/doctest.h>

using namespace meshgauge;

namespace {

api::Verdict judge(double lower, double upper, double limit) {
  Outcome outcome;
  outcome.lower = lower;
  outcome.upper = upper;
  return api::verdict(outcome, limit).value();
}

}  // namespace

TEST_CASE("gate: the interval decides") {
  CHECK(judge(0, 1, 2) == api::Verdict::pass);
  CHECK(judge(0, 2, 2) == api::Verdict::pass);  // at most
  CHECK(judge(3, 4, 2) == api::Verdict::fail);
  CHECK(judge(1, 3, 2) == api::Verdict::undecided);
  CHECK(judge(2, 3, 2) == api::Verdict::undecided);  // exactly 2 would pass
  CHECK(judge(0, 0, 0) == api::Verdict::pass);
}

TEST_CASE("gate: no gate, no verdict") { CHECK(!api::verdict(Outcome{}, std::nullopt)); }
