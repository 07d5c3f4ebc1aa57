#include "check/outcome.h"

#include <doctest/doctest.h>

#include <limits>

#include "check/run/gates.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

GateOutcome with(const Measured& found, bool warn_only) {
  GateOutcome outcome;
  outcome.gate = gate("part.stl", "cad.stl", found.limit);
  outcome.gate.warn_only = warn_only;
  outcome.measured = found;
  return outcome;
}

GateOutcome not_in_time(bool warn_only) {
  GateOutcome outcome = with(measured(0, 1, 2), warn_only);
  outcome.measured.reset();
  outcome.interrupted = true;
  outcome.error = Error{ErrorCode::out_of_time, "timed out before 'part.stl' was read", "a", ""};
  return outcome;
}

Report only(const GateOutcome& outcome, Undecided rule) {
  Report report;
  report.outcomes = {outcome};
  report.undecided = rule;
  return report;
}

}  // namespace

TEST_CASE("an undecided gate may only warn when there is an interval") {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const bool warn_only : {false, true}) {
    const auto rule = warn_only ? Undecided::separate : Undecided::warn;
    CHECK(only(with(measured(1, 3, 2, "timeout"), warn_only), rule).exit_code() == 0);
    CHECK(only(with(measured(0, infinity, 2, "timeout"), warn_only), rule).exit_code() == 2);
    CHECK(only(not_in_time(warn_only), rule).exit_code() == 2);
    CHECK(not_in_time(warn_only).level(rule) == Level::failure);
  }
  CHECK(only(not_in_time(true), Undecided::fail).exit_code() == 1);
}

TEST_CASE("a fail may only warn, whatever the upper end") {
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(only(with(measured(3, infinity, 2, "timeout"), true), Undecided::separate).exit_code() == 0);
  CHECK(only(with(measured(3, infinity, 2, "timeout"), false), Undecided::separate).exit_code() == 1);
}
