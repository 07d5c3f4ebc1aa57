#include "check/reports/junit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ctime>
#include <sstream>

#include <pugixml.hpp>

#include "api/names.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(value.c_str());
}

void add_text(pugi::xml_node node, const char* name, const std::string& text) {
  node.append_child(name).append_child(pugi::node_pcdata).set_value(text.c_str());
}

std::string seconds(double ms) {
  std::array<char, 64> text{};
  const double s = std::isfinite(ms) ? std::clamp(ms / 1000, 0.0, 1e9) : 0;
  return {text.begin(), std::to_chars(text.begin(), text.end(), s, std::chars_format::fixed, 3).ptr};
}

// The schema knows no time zones: this is UTC.
std::string timestamp(std::chrono::system_clock::time_point when) {
  const std::time_t time = std::chrono::system_clock::to_time_t(when);
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc)};
}

// Viewers make a package of what stands before the last dot.
std::string class_name(const Gate& gate) {
  if (gate.manifest.empty()) return "meshgauge.check";
  std::string stem = shown_name(std::filesystem::path(gate.manifest).stem().string());
  std::replace(stem.begin(), stem.end(), '.', '_');
  return "meshgauge." + stem;
}

std::string coordinates(const Vec3& p) { return shortest(p.x()) + " " + shortest(p.y()) + " " + shortest(p.z()); }

void add_property(pugi::xml_node properties, const char* name, const std::string& value) {
  pugi::xml_node property = properties.append_child("property");
  set(property, "name", name);
  set(property, "value", value);
}

void add_measured(pugi::xml_node properties, const Measured& measured) {
  add_property(properties, "lower", shortest(measured.lower));
  add_property(properties, "upper", shortest(measured.upper));
  add_property(properties, "limit", shortest(measured.limit));
  add_property(properties, "status", shown_name(measured.status));
  if (!measured.link.empty()) add_property(properties, "link", measured.link);
  if (!measured.witness) return;
  const Witness& witness = *measured.witness;
  add_property(properties, "witness.on", witness.on_candidate ? "candidate" : "baseline");
  add_property(properties, "witness.from", coordinates(witness.from));
  add_property(properties, "witness.from_triangle", std::to_string(witness.from_triangle));
  add_property(properties, "witness.to", coordinates(witness.to));
  add_property(properties, "witness.to_triangle", std::to_string(witness.to_triangle));
}

void add_properties(pugi::xml_node suite, const GateOutcome& outcome, Level level) {
  const Gate& gate = outcome.gate;
  pugi::xml_node properties = suite.append_child("properties");
  add_property(properties, "verdict", std::string(to_string(outcome.verdict())));
  add_property(properties, "level", std::string(to_string(level)));
  add_property(properties, "candidate", shown_name(gate.candidate.string()));
  add_property(properties, "baseline", shown_name(gate.baseline.string()));
  add_property(properties, "direction", std::string(api::name_of(api::kDirections, gate.options.direction)));
  if (const std::string unit = outcome.unit(); !unit.empty()) add_property(properties, "units", unit);
  for (const std::string& note : notes_of(outcome)) add_property(properties, "note", note);
  if (!gate.manifest.empty()) add_property(properties, "source", source_of(gate));
  if (outcome.measured) add_measured(properties, *outcome.measured);
}

std::string story_of(const GateOutcome& outcome) {
  std::string story = finding_of(outcome) + "\n";
  if (const std::string witness = witness_of(outcome); !witness.empty()) story += "witness: " + witness + "\n";
  if (const std::string advice = advice_of(outcome); !advice.empty()) story += advice + "\n";
  for (const std::string& note : notes_of(outcome)) story += "note: " + note + "\n";
  if (outcome.measured && !outcome.measured->link.empty()) story += "to be seen at: " + outcome.measured->link + "\n";
  story += "candidate: " + shown_name(outcome.gate.candidate.string()) + "\n";
  story += "baseline: " + shown_name(outcome.gate.baseline.string()) + "\n";
  if (const std::string source = source_of(outcome.gate); !source.empty()) story += "gate: " + source + "\n";
  return story;
}

void add_case(pugi::xml_node suite, const GateOutcome& outcome, Level level) {
  pugi::xml_node test = suite.append_child("testcase");
  set(test, "name", shown_name(outcome.gate.name));
  set(test, "classname", class_name(outcome.gate));
  set(test, "time", seconds(outcome.wall_ms));
  if (level != Level::failure) return;
  const bool error = outcome.verdict() == Verdict::error;
  pugi::xml_node failure = test.append_child(error ? "error" : "failure");
  set(failure, "message", finding_of(outcome));
  set(failure, "type", std::string(to_string(outcome.verdict())));
  failure.append_child(pugi::node_pcdata).set_value(story_of(outcome).c_str());
}

void add_suite(pugi::xml_node suites, const Report& report, std::size_t i, const std::string& when) {
  const GateOutcome& outcome = report.outcomes[i];
  const Level level = outcome.level(report.undecided);
  const bool error = outcome.verdict() == Verdict::error;
  pugi::xml_node suite = suites.append_child("testsuite");
  set(suite, "name", shown_name(outcome.gate.name));
  set(suite, "package", class_name(outcome.gate));
  set(suite, "id", std::to_string(i));
  set(suite, "timestamp", when);
  set(suite, "hostname", "localhost");  // required, and nobody's business
  set(suite, "tests", "1");
  set(suite, "failures", level == Level::failure && !error ? "1" : "0");
  set(suite, "errors", error ? "1" : "0");
  set(suite, "time", seconds(outcome.wall_ms));
  add_properties(suite, outcome, level);
  add_case(suite, outcome, level);
  add_text(suite, "system-out", (level == Level::warning ? "warning: " : "") + story_of(outcome));
  suite.append_child("system-err");
}

}  // namespace

std::string to_junit(const Report& report, std::chrono::system_clock::time_point when) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  set(declaration, "version", "1.0");
  set(declaration, "encoding", "UTF-8");
  pugi::xml_node suites = document.append_child("testsuites");
  for (std::size_t i = 0; i < report.outcomes.size(); ++i) add_suite(suites, report, i, timestamp(when));
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace meshgauge::check
