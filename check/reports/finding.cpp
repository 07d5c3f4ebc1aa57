#include "check/reports/finding.h"

#include <algorithm>
#include <span>

#include "api/base/digest.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

constexpr Rule kRules[] = {
    {"MG0001", "DistanceAboveLimit", "meshgauge/distance-above-limit",
     "The distance between two meshes is above its limit.",
     "The largest distance between the candidate and its baseline is certainly above the limit of the gate: at the "
     "witness, a point of one surface, the other surface is at least that far away. Look at the witness. If the change "
     "is wanted, take the candidate for the new baseline (meshgauge check --update-baselines) or raise the limit."},
    {"MG0002", "DistanceUndecided", "meshgauge/distance-undecided",
     "Whether a distance is within its limit was not decided.",
     "The limit of the gate lies inside the interval that was proved when the work stopped: the distance may be within "
     "the limit or above it. Give the gate more time (timeout), or a limit that is not so close to the distance."},
    {"MG0003", "NotMeasured", "meshgauge/not-measured", "Two meshes could not be compared.",
     "There is no interval: a file is missing or is not a mesh that can be read, or the service was not reached. The "
     "message names the defect. A gate that was not measured never passes."},
    {"MG0004", "AreaAboveLimit", "meshgauge/area-above-limit",
     "Too much of the area is farther than a distance from the other mesh.",
     "The share of the area that is farther than the gate's distance is certainly above its limit (max_share_beyond). "
     "The witness is where it is farthest. If the change is wanted, take the candidate for the new baseline (meshgauge "
     "check --update-baselines) or raise the limit."},
    {"MG0005", "ExpectationNotMet", "meshgauge/expectation-not-met", "A mesh is not as its gate expects.",
     "The candidate has open edges, too many triangles, another volume or the like: the message names what the gate "
     "expects (expect) and what was found. Repair the candidate, or change what the gate expects."},
    {"MG0006", "ZoneExceeded", "meshgauge/zone-exceeded",
     "A mesh reaches farther inside or outside of the other than its zone.",
     "The candidate is certainly farther inside of its baseline, or farther outside, than the limit of that side "
     "(zone). The message names the side and a point there. If the change is wanted, take the candidate for the new "
     "baseline (meshgauge check --update-baselines) or widen the zone."}};

constexpr std::size_t kDistance = 0, kUndecided = 1, kError = 2, kArea = 3, kExpectation = 4, kZone = 5;  // of kRules

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

std::span<const Rule> rules() { return kRules; }

std::size_t rule_of(const GateOutcome& outcome) {
  const Verdict verdict = outcome.verdict();
  if (outcome.measured && outcome.measured->verdict != verdict) return kExpectation;
  if (verdict != Verdict::fail) return verdict == Verdict::error ? kError : kUndecided;
  std::size_t rule = kArea;
  for (const Criterion& one : outcome.measured->criteria) {
    if (one.verdict != api::Verdict::fail || one.beyond) continue;
    if (one.side.empty()) return kDistance;
    rule = kZone;
  }
  return rule;
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
