#include "check/reports/reports.h"

#include <cmath>

#include "api/base/figures.h"
#include "api/options/names.h"
#include "api/result/junit.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

using api::shortest;
using Properties = std::vector<std::pair<std::string, std::string>>;

std::string class_name(const Gate& gate) {
  return api::junit_class(gate.manifest.empty() ? "check"
                                                : shown_name(std::filesystem::path(gate.manifest).stem().string()));
}

std::string coordinates(const Vec3& p) { return shortest(p.x()) + " " + shortest(p.y()) + " " + shortest(p.z()); }

// What the names of a limit's properties begin with: "", "region.bore.", "inside.", "share_beyond.".
std::string prefix_of(const Criterion& criterion) {
  if (criterion.beyond) return "share_beyond.";
  if (criterion.is_of_region()) return "region." + shown_name(criterion.region) + ".";
  return criterion.side.empty() ? "" : criterion.side + ".";
}

void add(const Criterion& criterion, Properties& properties) {
  const std::string prefix = prefix_of(criterion);
  if (criterion.beyond) properties.emplace_back(prefix + "distance", shortest(*criterion.beyond));
  if (criterion.refused.empty() && !prefix.empty()) {
    properties.emplace_back(prefix + "lower", shortest(criterion.lower));
    if (std::isfinite(criterion.upper)) properties.emplace_back(prefix + "upper", shortest(criterion.upper));
  }
  properties.emplace_back(prefix + "limit", shortest(criterion.limit));
  if (!prefix.empty()) properties.emplace_back(prefix + "verdict", std::string(to_string(criterion.verdict)));
  if (!criterion.refused.empty() && criterion.side == "outside")
    properties.emplace_back("sides.refused", shown_name(criterion.refused));
}

void add_measured(Properties& properties, const Measured& measured) {
  properties.emplace_back("lower", shortest(measured.lower));
  properties.emplace_back("upper", shortest(measured.upper));
  for (const Criterion& criterion : measured.criteria) add(criterion, properties);
  const auto terms = api::terms_json(measured.criteria.front());
  for (const auto& [name, value] : terms.items()) properties.emplace_back(name, shortest(value.get<double>()));
  properties.emplace_back("status", shown_name(measured.status));
  if (!measured.link.empty()) properties.emplace_back("link", measured.link);
  if (!measured.witness) return;
  const Witness& witness = *measured.witness;
  properties.emplace_back("witness.on", witness.from_mesh());
  properties.emplace_back("witness.from", coordinates(witness.from));
  properties.emplace_back("witness.from_triangle", std::to_string(witness.from_triangle));
  properties.emplace_back("witness.to", coordinates(witness.to));
  properties.emplace_back("witness.to_triangle", std::to_string(witness.to_triangle));
}

Properties properties_of(const GateOutcome& outcome, Level level) {
  const Gate& gate = outcome.gate;
  Properties properties{{"verdict", std::string(to_string(outcome.verdict()))},
                        {"level", std::string(to_string(level))},
                        {"direction", std::string(api::name_of(api::kDirections, gate.request.options.direction))}};
  if (!gate.candidate.empty()) properties.emplace_back("candidate", shown_name(gate.candidate.string()));
  if (!gate.baseline.empty()) properties.emplace_back("baseline", shown_name(gate.baseline.string()));
  if (const std::string unit = outcome.unit(); !unit.empty()) properties.emplace_back("units", unit);
  for (const std::string& note : notes_of(outcome)) properties.emplace_back("note", note);
  if (!gate.manifest.empty()) properties.emplace_back("source", source_of(gate));
  for (const Criterion& one : outcome.expectations)
    properties.emplace_back("expect." + one.name,
                            std::string(to_string(one.verdict)) + ": " + one.found + ", expected " + one.expected);
  if (outcome.measured) add_measured(properties, *outcome.measured);
  return properties;
}

std::string story_of(const GateOutcome& outcome) {
  std::string story = finding_of(outcome) + "\n";
  if (const std::string witness = witness_of(outcome); !witness.empty()) story += "witness: " + witness + "\n";
  if (const std::string advice = advice_of(outcome); !advice.empty()) story += advice + "\n";
  for (const std::string& note : notes_of(outcome)) story += "note: " + note + "\n";
  if (outcome.measured && !outcome.measured->link.empty()) story += "to be seen at: " + outcome.measured->link + "\n";
  if (!outcome.gate.candidate.empty()) story += "candidate: " + shown_name(outcome.gate.candidate.string()) + "\n";
  if (!outcome.gate.baseline.empty()) story += "baseline: " + shown_name(outcome.gate.baseline.string()) + "\n";
  if (const std::string source = source_of(outcome.gate); !source.empty()) story += "gate: " + source + "\n";
  return story;
}

std::string suite_of(const GateOutcome& outcome, Level level, std::size_t id,
                     std::chrono::system_clock::time_point when) {
  const bool error = outcome.verdict() == Verdict::error;
  api::JUnitSuite suite{shown_name(outcome.gate.name), class_name(outcome.gate), id, when};
  suite.failures = level == Level::failure && !error ? 1 : 0;
  suite.errors = error ? 1 : 0;
  suite.seconds = outcome.wall_ms / 1000;
  suite.properties = properties_of(outcome, level);
  api::JUnitCase test{suite.name, suite.package, suite.seconds, std::nullopt};
  if (level == Level::failure) {
    test.defect = {error ? "error" : "failure", std::string(to_string(outcome.verdict())), finding_of(outcome),
                   story_of(outcome)};
  }
  return junit_suite(suite) + junit_case(test) +
         api::junit_suite_end((level == Level::warning ? "warning: " : "") + story_of(outcome));
}

}  // namespace

std::string to_junit(const Report& report, std::chrono::system_clock::time_point when) {
  std::string text = api::junit_begin();
  for (std::size_t i = 0; i < report.outcomes.size(); ++i) {
    text += suite_of(report.outcomes[i], report.outcomes[i].level(report.undecided), i, when);
  }
  return text + api::junit_end();
}

}  // namespace meshgauge::check
