#include "engine/extras/area/quantile.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

struct Weighted {
  Linear values;
  double weight;
};

// One function of each part.
template <class FunctionOf>
std::optional<std::vector<Weighted>> weighted(const AllParts& parts, const Interrupted& stop, const FunctionOf& of) {
  std::vector<Weighted> items;
  items.reserve(parts.closed.size() + parts.open.size());
  const auto add = [&](const auto& part) { items.push_back({of(part.enclosure), part.weight}); };
  if (!each_unless(stop, parts.closed.size(), [&](std::size_t i) { add(parts.closed[i]); })) return std::nullopt;
  if (!each_unless(stop, parts.open.size(), [&](std::size_t i) { add(parts.open[i]); })) return std::nullopt;
  return items;
}

// Bisects `bracket` where is_beyond(sum of weight * share beyond t) changes from true to false. nullopt: interrupted.
template <class IsBeyond>
std::optional<AreaInterval> bisect(std::vector<Weighted> items, AreaInterval bracket, double resolution,
                                   const Interrupted& stop, const IsBeyond& is_beyond) {
  double above = 0;
  while (bracket.upper - bracket.lower > resolution) {
    const double t = bracket.lower + (bracket.upper - bracket.lower) / 2;
    if (!(t > bracket.lower && t < bracket.upper)) break;
    double sum = above;
    if (!each_unless(stop, items.size(),
                     [&](std::size_t i) { sum += items[i].weight * share_beyond(items[i].values, t); }))
      return std::nullopt;
    if (is_beyond(sum)) {
      bracket.lower = t;
      std::erase_if(items, [&](const Weighted& item) { return most(item.values) <= t; });
    } else {
      bracket.upper = t;
      std::erase_if(items, [&](const Weighted& item) {
        if (least(item.values) <= t) return false;
        above += item.weight;
        return true;
      });
    }
  }
  return bracket;
}

}  // namespace

std::optional<AreaInterval> quantile(double p, const TotalArea& area, const AllParts& parts, const AreaInterval& known,
                                     double resolution, const Interrupted& stop) {
  constexpr double kRound = 2 * rounding::kUnit;  // of 1 - p
  const auto share = [&](double sum) { return area.share({sum, sum, false, false}); };
  auto highs = weighted(parts, stop, [](const Enclosure& enclosure) { return enclosure.high; });
  if (!highs) return std::nullopt;
  const auto above = bisect(*std::move(highs), known, resolution, stop,
                            [&](double sum) { return !(share(sum).upper <= 1 - p - kRound); });
  if (!above) return std::nullopt;
  auto lows = weighted(parts, stop, [](const Enclosure& enclosure) { return enclosure.low; });
  if (!lows) return std::nullopt;
  const auto below = bisect(*std::move(lows), {known.lower, above->upper}, resolution, stop,
                            [&](double sum) { return share(sum).lower > 1 - p + kRound; });
  if (!below) return std::nullopt;
  return AreaInterval{below->lower, above->upper};
}

}  // namespace meshgauge
