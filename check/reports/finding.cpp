#include "check/reports/finding.h"

#include <algorithm>
#include <span>

#include "api/base/digest.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

// Whether the gate fails, by limits alone of which `is` returns true.
template <class Is>
bool fails_only(const GateOutcome& outcome, const Is& is) {
  if (!outcome.measured || outcome.measured->verdict != Verdict::fail) return false;
  return std::ranges::all_of(outcome.measured->criteria,
                             [&](const Criterion& c) { return c.verdict != api::Verdict::fail || is(c); });
}

}  // namespace

Location location_of(const Gate& gate) {
  if (gate.manifest.empty()) return {gate.candidate.empty() ? "." : gate.candidate, 1};
  return {gate.manifest, std::max(gate.line, 1)};
}

std::string uri_path(const std::filesystem::path& file) {
  return percent_encoded(file.lexically_normal().generic_string(), "-._~/");
}

std::string fingerprint_of(const Gate& gate) {
  const std::string text = std::filesystem::path(gate.manifest).lexically_normal().generic_string() + '\n' + gate.name;
  return api::sha256_hex(std::as_bytes(std::span(text))).substr(0, 32);
}

bool fails_by_expectation(const GateOutcome& outcome) {
  return outcome.measured && outcome.measured->verdict != outcome.verdict();
}

bool fails_by_area(const GateOutcome& outcome) {
  return fails_only(outcome, [](const Criterion& c) { return c.beyond.has_value(); });
}

bool fails_by_zone(const GateOutcome& outcome) {
  return fails_only(outcome, [](const Criterion& c) { return c.beyond || !c.side.empty(); }) && !fails_by_area(outcome);
}

std::string description_of(const GateOutcome& outcome) {
  std::string text = "Gate '" + shown_name(outcome.gate.name) + "': " + finding_of(outcome);
  if (outcome.measured) text += ".";
  if (const std::string advice = advice_of(outcome); !advice.empty()) text += " " + advice;
  for (const std::string& note : notes_of(outcome)) text += " Note: " + note + ".";
  if (const std::string witness = witness_of(outcome); !witness.empty()) text += " Witness: " + witness + ".";
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return text;
}

}  // namespace meshgauge::check
