#include "api/result/examination.h"

#include <initializer_list>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "check/reports/wording.h"
#include "check/run/gates.h"

using namespace meshgauge;
using namespace meshgauge::check;
using Json = nlohmann::ordered_json;

namespace {

Json no_edges() { return {{"count", 0}, {"first", nullptr}}; }

Json mesh(double low, double high) {
  return {{"triangles", 12},
          {"degenerate", 1},
          {"topology",
           {{"watertight", true},
            {"oriented", true},
            {"components", 2},
            {"open_edges", no_edges()},
            {"non_manifold_edges", no_edges()},
            {"flipped_edges", no_edges()},
            {"volume", {{"lower", low}, {"upper", high}}}}}};
}

Json open_mesh() {
  Json json = mesh(0, 0);
  json["topology"]["watertight"] = false;
  json["topology"]["open_edges"] = {{"count", 14}, {"first", {0.5, 0, 1}}};
  json["topology"]["volume"] = nullptr;
  return json;
}

GateOutcome outcome_of(const Expectations& expect, const Json& a, const Json& b = mesh(1000, 1000)) {
  GateOutcome outcome;
  outcome.gate = gate("a.stl", "b.stl", 1);
  outcome.gate.request.options.units.limit = LengthUnit::millimeter;
  outcome.gate.request.options.expect = expect;
  outcome.measured = measured(0.1, 0.2, 1);
  outcome.measured->document["meshes"] = {{"a", a}, {"b", b}};
  outcome.expectations = api::examined(expect, outcome.measured->document["meshes"], outcome.unit());
  return outcome;
}

Verdict only(const Expectations& expect, const Json& a, const Json& b = mesh(1000, 1000)) {
  const GateOutcome outcome = outcome_of(expect, a, b);
  REQUIRE(outcome.expectations.size() == 1);
  CHECK(outcome.verdict() == verdict_of(outcome.expectations[0].verdict));  // the distance passes
  return verdict_of(outcome.expectations[0].verdict);
}

Expectations within(double share) {
  Expectations expect;
  expect.volume_within = share;
  return expect;
}

Expectations volume(const api::Span& span) {
  Expectations expect;
  expect.volume = span;
  return expect;
}

Expectations triangles(const api::Span& span) {
  Expectations expect;
  expect.triangles = span;
  return expect;
}

Expectations oriented() {
  Expectations expect;
  expect.oriented = true;
  return expect;
}

Expectations watertight(bool is) {
  Expectations expect;
  expect.watertight = is;
  return expect;
}

}  // namespace

TEST_CASE("expectations: none without asking") {
  CHECK(outcome_of({}, mesh(1, 1)).expectations.empty());
  CHECK(!Expectations().of_topology());
  CHECK(!triangles({0, 1}).of_topology());
  CHECK(watertight(false).of_topology());
  CHECK(within(0.1).of_topology());
}

TEST_CASE("expectations: counts are in a span, both ends included") {
  CHECK(only(triangles({12, 12}), mesh(1, 1)) == Verdict::pass);
  CHECK(only(triangles({{}, 12}), mesh(1, 1)) == Verdict::pass);
  CHECK(only(triangles({12, {}}), mesh(1, 1)) == Verdict::pass);
  CHECK(only(triangles({{}, 11}), mesh(1, 1)) == Verdict::fail);
  CHECK(only(triangles({13, {}}), mesh(1, 1)) == Verdict::fail);
  CHECK(unmet_of(outcome_of(triangles({{}, 11}), mesh(1, 1))) == "triangles: 12, expected at most 11");
}

TEST_CASE("expectations: an open mesh names its first open edge, and has no volume") {
  CHECK(only(watertight(true), open_mesh()) == Verdict::fail);
  CHECK(only(watertight(false), open_mesh()) == Verdict::pass);
  CHECK(unmet_of(outcome_of(watertight(true), open_mesh())) ==
        "watertight: no: 14 open edges, the first at (0.5, 0, 1) mm, expected yes");
  CHECK(only(within(1), open_mesh()) == Verdict::fail);
  CHECK(only(within(1), mesh(1, 1), open_mesh()) == Verdict::fail);
  CHECK(only(volume({0, 1}), open_mesh()) == Verdict::fail);
  CHECK(unmet_of(outcome_of(within(0.01), mesh(1, 1), open_mesh())) ==
        "volume.within: none: the baseline is not watertight, expected within 1 % of the baseline's volume");
}

TEST_CASE("expectations: a mesh without edges is not oriented") {
  Json cloud = mesh(1, 1);
  CHECK(only(oriented(), cloud) == Verdict::pass);
  cloud["topology"]["edges"] = 0;
  CHECK(only(oriented(), cloud) == Verdict::fail);
}

TEST_CASE("expectations: a volume is decided by its whole interval") {
  CHECK(only(volume({1, 2}), mesh(1, 2)) == Verdict::pass);
  CHECK(only(volume({1, 2}), mesh(2.1, 2.2)) == Verdict::fail);
  CHECK(only(volume({1, 2}), mesh(1.9, 2.1)) == Verdict::undecided);
  CHECK(only(volume({0, {}}), mesh(-2, -1)) == Verdict::fail);
  CHECK(only(within(0.01), mesh(991, 1009)) == Verdict::pass);
  CHECK(only(within(0.01), mesh(1011, 1012)) == Verdict::fail);
  CHECK(only(within(0.01), mesh(988, 989)) == Verdict::fail);
  CHECK(only(within(0.01), mesh(1009, 1011)) == Verdict::undecided);
  CHECK(only(within(0.01), mesh(1000, 1000), mesh(900, 1100)) == Verdict::undecided);
  CHECK(only(within(0.01), mesh(-1000, -1000)) == Verdict::fail);
  CHECK(only(within(0.01), mesh(-1000, -1000), mesh(-1001, -1001)) == Verdict::pass);
  CHECK(unmet_of(outcome_of(within(0.01), mesh(1200, 1200))) ==
        "volume.within: 1200 mm^3, expected within 1 % of the baseline's 1000 mm^3");
}

TEST_CASE("expectations: what a document leaves out is undecided, never a pass") {
  for (const Json& a : std::initializer_list<Json>{nullptr,
                                                   1,
                                                   Json::object(),
                                                   {{"topology", nullptr}},
                                                   {{"topology", {{"watertight", "true"}, {"volume", 3}}}}}) {
    CHECK(only(watertight(true), a) == Verdict::undecided);
    CHECK(only(triangles({0, 100}), a) == Verdict::undecided);
    CHECK(only(within(1), a) == Verdict::undecided);
  }
  Json endless = mesh(1, 1);
  endless["topology"]["volume"] = {{"lower", 1}, {"upper", nullptr}};
  CHECK(only(volume({0, 5}), endless) == Verdict::undecided);
  CHECK(only(within(1), endless, endless) == Verdict::undecided);
}

TEST_CASE("expectations: the verdict of a gate is the worst of all") {
  GateOutcome outcome = outcome_of(watertight(true), open_mesh());
  CHECK(outcome.verdict() == Verdict::fail);
  CHECK(outcome.advice() == "Repair the candidate, or change what the gate expects.");
  CHECK(finding_of(outcome) ==
        "watertight: no: 14 open edges, the first at (0.5, 0, 1) mm, expected yes; the distance is at most 0.2 mm, "
        "within the limit of 1 mm");
  outcome.measured->verdict = Verdict::undecided;
  CHECK(outcome.verdict() == Verdict::fail);
  outcome = outcome_of(watertight(true), Json::object());
  CHECK(outcome.verdict() == Verdict::undecided);
  CHECK(outcome.advice() == "Decided by a longer timeout than 30 s, or by another expectation.");
  outcome.measured->verdict = Verdict::fail;
  CHECK(outcome.verdict() == Verdict::fail);
}
