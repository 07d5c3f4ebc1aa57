#include "engine/search/conclusion.h"

#include <algorithm>

namespace meshgauge {

std::optional<Rule> rule_met(const Options& options, double lower, double upper, double diagonal_a) {
  const Tolerance& tolerance = options.tolerance;
  const double width = upper - lower;
  if (tolerance.absolute && width <= *tolerance.absolute) return Rule::absolute;
  if (tolerance.diagonal && width <= *tolerance.diagonal * diagonal_a) return Rule::diagonal;
  if (tolerance.relative && width <= *tolerance.relative * lower) return Rule::relative;
  return std::nullopt;
}

bool gate_decided(const std::optional<double>& max_distance, double lower, double upper) {
  return max_distance && (upper <= *max_distance || lower > *max_distance);
}

void take_maximum(Outcome& outcome) {
  outcome.lower = 0;
  outcome.upper = 0;
  for (const auto* directed : {&outcome.a_to_b, &outcome.b_to_a}) {
    if (!*directed) continue;
    outcome.lower = std::max(outcome.lower, (*directed)->bounds.lower);
    outcome.upper = std::max(outcome.upper, (*directed)->bounds.upper);
  }
}

}  // namespace meshgauge
