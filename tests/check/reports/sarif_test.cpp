#include "check/reports/reports.h"

#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "check/criteria.h"
#include "check/reports/sample_reports.h"

using namespace meshgauge;
using namespace meshgauge::check;
using nlohmann::json;

namespace {

json run_of(const Report& report) { return json::parse(to_sarif(report))["runs"][0]; }

json only(const GateOutcome& outcome) { return run_of(samples::report_of({outcome}))["results"].at(0); }

std::string uri(const json& location) { return location["physicalLocation"]["artifactLocation"]["uri"]; }

}  // namespace

TEST_CASE("sarif: a finding for each gate that did not pass, at its line of the manifest") {
  const json run = run_of(samples::ordinary());
  REQUIRE(run["results"].size() == 4);
  const json& lid = run["results"][0];
  CHECK(lid["ruleId"] == "MG0001");
  CHECK(lid["level"] == "error");
  CHECK(uri(lid["locations"][0]) == "parts/gates.yaml");
  CHECK(lid["locations"][0]["physicalLocation"]["region"]["startLine"] == 7);
  CHECK(uri(lid["relatedLocations"][0]) == "build/lid.stl");
  CHECK(uri(lid["relatedLocations"][1]) == "baselines/lid.stl");
  CHECK(lid["properties"]["witness"]["from"] == json({1.5, -2, 0.1 + 0.2}));
  CHECK(lid["message"]["text"].get<std::string>().find("(1.5, -2, 0.3) mm on triangle 17") != std::string::npos);
  CHECK(run["results"][1]["ruleId"] == "MG0002");
  CHECK(run["results"][2]["ruleId"] == "MG0003");
  CHECK(run["results"][3]["level"] == "warning");
  for (const json& result : run["results"]) {
    CHECK(run["tool"]["driver"]["rules"][result["ruleIndex"].get<std::size_t>()]["id"] == result["ruleId"]);
  }
  CHECK(run["properties"] == json{{"gates", 5}, {"pass", 1}, {"fail", 2}, {"undecided", 1}, {"error", 1}});
}

TEST_CASE("sarif: levels and exit codes") {
  Report report = samples::report_of({samples::undecided("hinge")});
  CHECK(run_of(report)["results"][0]["level"] == "error");
  CHECK(run_of(report)["invocations"][0] == json{{"exitCode", 2}, {"executionSuccessful", true}});
  report.undecided = Undecided::warn;
  CHECK(run_of(report)["results"][0]["level"] == "note");
  CHECK(run_of(report)["invocations"][0]["exitCode"] == 0);
  CHECK(run_of(samples::ordinary())["invocations"][0] == json{{"exitCode", 3}, {"executionSuccessful", false}});
  report.interrupted = true;
  CHECK(run_of(report)["invocations"][0]["executionSuccessful"] == false);
}

TEST_CASE("sarif: without a manifest the finding is at the candidate") {
  GateOutcome outcome = samples::failed("a");
  outcome.gate.manifest.clear();
  outcome.gate.line = 0;
  outcome.gate.candidate = "out/./a b.stl";
  CHECK(uri(only(outcome)["locations"][0]) == "out/a%20b.stl");
  outcome.gate.candidate = "/out/ä.stl";
  CHECK(uri(only(outcome)["locations"][0]) == "file:///out/%C3%A4.stl");
  CHECK_FALSE(only(outcome)["locations"][0]["physicalLocation"]["artifactLocation"].contains("uriBaseId"));
}

TEST_CASE("sarif: addresses of any bytes") {
  GateOutcome outcome = samples::failed("a");
  outcome.gate.candidate = "a:b/c?d#e%f\\g\xff\n.stl";
  CHECK(uri(only(outcome)["relatedLocations"][0]) == "a%3Ab/c%3Fd%23e%25f%5Cg%FF%0A.stl");
}

TEST_CASE("sarif: a fingerprint is that of the gate, whatever is measured") {
  const auto of = [](const GateOutcome& outcome) -> json { return only(outcome)["partialFingerprints"]; };
  CHECK(of(samples::failed("lid")) == of(samples::undecided("lid")));
  CHECK(of(samples::failed("lid")) != of(samples::failed("bracket")));
  GateOutcome moved = samples::failed("lid");
  moved.gate.line = 99;
  moved.gate.manifest = "./parts/gates.yaml";
  CHECK(of(moved) == of(samples::failed("lid")));
  CHECK(of(moved)["primaryLocationLineHash"].get<std::string>().size() == 34);

  std::set<std::string> seen;
  const json hostile = run_of(samples::hostile());
  for (const json& result : hostile["results"]) seen.insert(result["partialFingerprints"].dump());
  CHECK(seen.size() == samples::hostile_names().size());
}

TEST_CASE("sarif: nothing in a name is a link or a placeholder") {
  const json message = only(samples::failed("[x](http://example.com) {0} \\"))["message"];
  CHECK(message["text"].get<std::string>().find("'\\[x\\](http://example.com) {{0}} \\\\'") != std::string::npos);
}

TEST_CASE("sarif: the gate's page is the result's hostedViewerUri") {
  GateOutcome seen = samples::failed("lid");
  CHECK_FALSE(only(seen).contains("hostedViewerUri"));
  seen.measured->link = "https://ci.example/c/1";
  CHECK(only(seen)["hostedViewerUri"] == "https://ci.example/c/1");
}

TEST_CASE("sarif: too much area has a rule of its own") {
  const json finding = only(samples::area("lid", 0.02));
  CHECK(finding["ruleId"] == "MG0004");
  CHECK(finding["properties"]["criteria"][0]["limit"] == 0.01);
  CHECK(!finding["properties"].contains("limit"));
  CHECK(finding["message"]["text"].get<std::string>().find("between 2.201 and 2.27 % of the area") !=
        std::string::npos);
}

TEST_CASE("sarif: a zone that is exceeded has a rule of its own, unless the distance is too large as well") {
  GateOutcome zone = samples::zone("lid");
  const json run = run_of(samples::report_of({zone})), finding = run["results"][0];
  CHECK(finding["ruleId"] == "MG0006");
  CHECK(run["tool"]["driver"]["rules"][finding["ruleIndex"].get<std::size_t>()]["id"] == "MG0006");
  CHECK(finding["properties"]["criteria"][0]["upper"] == 0.07);
  const std::vector<Criterion> sides = zone.measured->criteria;
  set_criteria(*zone.measured, {distance(0.06, 0.07, 0), sides[0], sides[1]});
  CHECK(only(zone)["ruleId"] == "MG0001");
  set_criteria(*zone.measured, {distance(0.06, 0.07, 1), sides[0], sides[1]});
  CHECK(only(zone)["ruleId"] == "MG0006");
}
