#include "api/gate.h"

namespace meshgauge::api {

std::string_view to_string(Verdict verdict) {
  constexpr std::string_view kNames[] = {"pass", "fail", "undecided"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::optional<Verdict> verdict(const Outcome& outcome, const std::optional<double>& max_distance) {
  if (!max_distance) return std::nullopt;
  if (outcome.upper <= *max_distance) return Verdict::pass;
  if (outcome.lower > *max_distance) return Verdict::fail;
  return Verdict::undecided;
}

}  // namespace meshgauge::api
