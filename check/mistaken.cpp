#include "check/mistaken.h"

#include <set>
#include <utility>

#include "api/refused.h"
#include "engine/hausdorff.h"

namespace meshgauge::check {
namespace {

std::string place_of(const std::string& manifest, const Mistake& mistake) {
  if (manifest.empty()) return "meshgauge check";
  if (mistake.line == 0) return manifest;
  return manifest + ":" + std::to_string(mistake.line) + ":" + std::to_string(mistake.column);
}

}  // namespace

Report mistaken(const std::string& manifest, const std::vector<Mistake>& mistakes) {
  Report report;
  report.version = version();
  std::set<std::string> taken;
  for (const Mistake& mistake : mistakes) {
    GateOutcome outcome;
    const std::string place = place_of(manifest, mistake);
    outcome.gate.name = place;
    for (int i = 2; !taken.insert(outcome.gate.name).second; ++i) {
      outcome.gate.name = place + " (" + std::to_string(i) + ")";
    }
    outcome.gate.manifest = manifest;
    outcome.gate.line = mistake.line;
    outcome.error = refused(mistake.message);
    report.outcomes.push_back(std::move(outcome));
  }
  return report;
}

}  // namespace meshgauge::check
