#include "check/reports/reports.h"

#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "check/reports/sample_reports.h"

using namespace meshgauge;
using namespace meshgauge::check;
using nlohmann::json;

TEST_CASE("code quality: a finding for each gate that did not pass") {
  const json findings = json::parse(to_code_quality(samples::ordinary()));
  REQUIRE(findings.size() == 4);
  CHECK(findings[0]["check_name"] == "meshgauge/distance-above-limit");
  CHECK(findings[0]["severity"] == "major");
  CHECK(findings[0]["location"] == json{{"path", "parts/gates.yaml"}, {"lines", {{"begin", 7}}}});
  CHECK(findings[0]["description"].get<std::string>().rfind("Gate 'lid': the distance is at least 0.0968 mm", 0) == 0);
  CHECK(findings[1]["check_name"] == "meshgauge/distance-undecided");
  CHECK(findings[1]["severity"] == "major");
  CHECK(findings[2]["check_name"] == "meshgauge/not-measured");
  CHECK(findings[2]["severity"] == "critical");
  CHECK(findings[3]["severity"] == "minor");
  Report allowed = samples::report_of({samples::undecided("hinge")});
  allowed.undecided = Undecided::warn;
  CHECK(json::parse(to_code_quality(allowed))[0]["severity"] == "info");
  CHECK(to_code_quality(samples::report_of({samples::passed("a")})) == "[]\n");
}

TEST_CASE("code quality: one line of text, and a fingerprint of each gate") {
  std::set<std::string> seen;
  const json findings = json::parse(to_code_quality(samples::hostile()));
  for (const json& finding : findings) {
    seen.insert(finding["fingerprint"].get<std::string>());
    CHECK(finding["description"].get<std::string>().find('\n') == std::string::npos);
  }
  CHECK(seen.size() == samples::hostile_names().size());
}

TEST_CASE("code quality: too much area is named so") {
  const json findings = json::parse(to_code_quality(samples::report_of({samples::area("lid", 0.02)})));
  CHECK(findings[0]["check_name"] == "meshgauge/area-above-limit");
}

TEST_CASE("code quality: a zone that is exceeded is named so") {
  const json findings = json::parse(to_code_quality(samples::report_of({samples::zone("lid")})));
  CHECK(findings[0]["check_name"] == "meshgauge/zone-exceeded");
}
