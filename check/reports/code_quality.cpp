#include "check/reports/reports.h"

#include "check/reports/finding.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

const char* check_name(const GateOutcome& outcome) {
  return outcome.verdict() == Verdict::pass ? "meshgauge/part-not-measured" : rules()[rule_of(outcome)].slug;
}

const char* severity_of(const GateOutcome& outcome, Undecided rule) {
  const Verdict verdict = outcome.verdict();
  if (verdict == Verdict::error) return "critical";
  if (outcome.level(rule) == Level::failure) return "major";
  return verdict == Verdict::fail ? "minor" : "info";
}

Json finding_json(const GateOutcome& outcome, Undecided rule) {
  const Location place = location_of(outcome.gate);
  // GitLab compares the path with those of the repository, so it is not a URI.
  const std::string path = shown_name(place.file.lexically_normal().generic_string());
  return {{"type", "issue"},
          {"description", description_of(outcome)},
          {"check_name", check_name(outcome)},
          {"fingerprint", fingerprint_of(outcome.gate)},
          {"severity", severity_of(outcome, rule)},
          {"location", {{"path", path}, {"lines", {{"begin", place.line}}}}}};
}

}  // namespace

std::string to_code_quality(const Report& report) {
  Json findings = Json::array();
  for (const GateOutcome& outcome : report.outcomes) {
    const bool is_whole = outcome.verdict() == Verdict::pass && unmeasured_of(outcome).empty();
    if (!is_whole) findings.push_back(finding_json(outcome, report.undecided));
  }
  return findings.dump(2) + "\n";
}

}  // namespace meshgauge::check
