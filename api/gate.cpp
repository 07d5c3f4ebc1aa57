#include "api/gate.h"

#include <algorithm>

namespace meshgauge::api {
namespace {

Verdict worst(Verdict a, Verdict b) {
  if (a == Verdict::fail || b == Verdict::fail) return Verdict::fail;
  return a == Verdict::pass ? b : a;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  constexpr std::string_view kNames[] = {"pass", "fail", "undecided"};
  return kNames[static_cast<std::size_t>(verdict)];
}

Verdict verdict_within(double lower, double upper, double limit) {
  if (upper <= limit) return Verdict::pass;
  return lower > limit ? Verdict::fail : Verdict::undecided;
}

Options engine_options(const ComparisonOptions& options) {
  Options engine = options;
  if (!options.max_share_beyond) return engine;
  if (!engine.areas) engine.areas.emplace();
  engine.areas->beyond.push_back({options.max_share_beyond->distance, options.max_share_beyond->share});
  return engine;
}

std::optional<AreaInterval> share_beyond(const Outcome& outcome, const ComparisonOptions& options) {
  if (!options.max_share_beyond || !outcome.areas) return std::nullopt;
  AreaInterval share;
  for (const auto* direction : {&outcome.areas->a_to_b, &outcome.areas->b_to_a}) {
    if (!*direction) continue;
    const AreaInterval& found = (*direction)->beyond.back();
    share = {std::max(share.lower, found.lower), std::max(share.upper, found.upper)};
  }
  return share;
}

std::optional<Verdict> verdict(const Outcome& outcome, const ComparisonOptions& options) {
  std::optional<Verdict> found;
  if (options.max_distance) found = verdict_within(outcome.lower, outcome.upper, *options.max_distance);
  if (const auto share = share_beyond(outcome, options)) {
    const Verdict of_share = verdict_within(share->lower, share->upper, options.max_share_beyond->share);
    found = found ? worst(*found, of_share) : of_share;
  }
  return found;
}

}  // namespace meshgauge::api
