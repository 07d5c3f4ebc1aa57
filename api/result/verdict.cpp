#include "api/result/verdict.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

namespace meshgauge::api {

std::string_view to_string(Verdict verdict) { return name_of(kVerdicts, verdict); }

int severity(Verdict verdict) { return verdict == Verdict::fail ? 2 : verdict == Verdict::undecided ? 1 : 0; }

Verdict worst(Verdict a, Verdict b) { return severity(a) < severity(b) ? b : a; }

Verdict verdict_within(double lower, double upper, double limit, double uncertainty) {
  if (upper <= less_uncertainty(limit, uncertainty)) return Verdict::pass;
  return lower > plus_uncertainty(limit, uncertainty) ? Verdict::fail : Verdict::undecided;
}

DistanceLimit shown_limit(std::span<const DistanceLimit> limits, double uncertainty) {
  const auto rank = [&](const DistanceLimit& one) {
    const int worse = severity(verdict_within(one.lower, one.upper, one.limit, uncertainty));
    return std::tuple(worse, one.side.empty(), worse == 0 ? one.limit : -one.limit);
  };
  return *std::ranges::max_element(limits, {}, rank);
}

std::optional<AreaInterval> share_beyond(const Outcome& outcome, const ComparisonOptions& options) {
  if (!options.max_share_beyond) return std::nullopt;
  AreaInterval share;
  const std::size_t asked = options.uncertainty > 0 ? 2 : 1;
  const auto add = [&](const std::optional<AreaBounds>& found) {
    const bool known = found && found->beyond.size() >= asked;
    share.lower = std::max(share.lower, known ? found->beyond.back().lower : 0);
    share.upper = std::max(share.upper, known ? found->beyond[found->beyond.size() - asked].upper : 1);
  };
  const AreaOutcome areas = outcome.areas.value_or(AreaOutcome{});
  if (options.direction != Direction::b_to_a) add(areas.a_to_b);
  if (options.direction != Direction::a_to_b) add(areas.b_to_a);
  return share;
}

}  // namespace meshgauge::api
