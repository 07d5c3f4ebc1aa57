#include "api/gate.h"

namespace meshgauge::api {

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::undecided:
      return "undecided";
  }
  return "";
}

std::optional<Verdict> verdict(const Outcome& outcome, const std::optional<double>& max_distance) {
  if (!max_distance) return std::nullopt;
  if (outcome.upper <= *max_distance) return Verdict::pass;
  if (outcome.lower > *max_distance) return Verdict::fail;
  return Verdict::undecided;
}

}  // namespace meshgauge::api
