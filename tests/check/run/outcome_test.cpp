#include "check/outcome.h"

#include <doctest/doctest.h>

#include <limits>
#include <tuple>

#include "api/result/examination.h"
#include "check/run/gates.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

GateOutcome with(const Measured& found, bool warn_only) {
  GateOutcome outcome;
  outcome.gate = gate("part.stl", "cad.stl", found.criteria.front().limit);
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

TEST_CASE("an undecided gate fails where nothing is known of its area or of an expectation") {
  GateOutcome outcome = with(measured(0, 1, 2), false);
  const auto code = [&] { return only(outcome, Undecided::warn).exit_code(); };
  for (const auto& [lower, upper, expected] : {std::tuple(0.0, 1.0, 2), {0.0, 0.9, 0}, {0.1, 1.0, 0}}) {
    set_criteria(*outcome.measured, {distance(0, 1, 2), share(0.5, 0.25, lower, upper, "timeout")});
    CHECK(code() == expected);
  }
  outcome.expectations = {api::expectation("volume", api::Verdict::undecided, "1 .. 2", "at least 1.5")};
  CHECK(code() == 0);
  outcome.expectations.push_back(api::expectation("watertight", api::Verdict::undecided, "not known", "yes", false));
  CHECK(code() == 2);
}

TEST_CASE("a candidate without triangles counts only if it is declared") {
  Gate asked = gate("cut.obj", "cad.stl", 1);
  nlohmann::ordered_json document = {{"meshes", {{"a", {{"format", "obj"}, {"vertices", 3}, {"triangles", 0}}}}}};
  REQUIRE(undeclared_cloud(asked, document));
  CHECK(undeclared_cloud(asked, document)->message ==
        "'cut.obj' has 3 points and no faces; if it is a point cloud, declare it by --cloud");
  asked.manifest = "gates.yaml";
  CHECK(undeclared_cloud(asked, document)->message.ends_with("declare it by 'cloud: true' in the manifest"));
  document["meshes"]["a"]["vertices"] = "many";
  CHECK(undeclared_cloud(asked, document));
  document["meshes"]["a"]["format"] = "xyz";
  CHECK(!undeclared_cloud(asked, document));
  document["meshes"]["a"]["format"] = nullptr;
  CHECK(undeclared_cloud(asked, document));
  asked.cloud = true;
  CHECK(!undeclared_cloud(asked, document));
  asked.cloud = false;
  document["meshes"]["a"]["triangles"] = 1;
  CHECK(!undeclared_cloud(asked, document));
  CHECK(!undeclared_cloud(asked, {{"meshes", {1, 2}}}));
  api::MeshFacts facts;
  facts.vertices = 3;
  CHECK(undeclared_cloud(asked, facts)->message.starts_with("'cut.obj' has 3 points and no faces"));
  facts.triangles = 1;
  CHECK(!undeclared_cloud(asked, facts));
}

TEST_CASE("a fail may only warn, whatever the upper end") {
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(only(with(measured(3, infinity, 2, "timeout"), true), Undecided::separate).exit_code() == 0);
  CHECK(only(with(measured(3, infinity, 2, "timeout"), false), Undecided::separate).exit_code() == 1);
}
