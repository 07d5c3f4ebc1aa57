#include "engine/area/quantile.h"

#include <algorithm>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

struct Weighted {
  Linear values;
  double weight;
};

double least(const Linear& f) { return std::min({f[0], f[1], f[2]}); }
double most(const Linear& f) { return std::max({f[0], f[1], f[2]}); }

// Bisects `bracket` where is_beyond(sum of weight * share beyond t) changes from true to false.
template <class IsBeyond>
AreaInterval bisect(std::vector<Weighted>& items, AreaInterval bracket, double resolution, const IsBeyond& is_beyond) {
  double above = 0;
  while (bracket.upper - bracket.lower > resolution) {
    const double t = bracket.lower + (bracket.upper - bracket.lower) / 2;
    if (!(t > bracket.lower && t < bracket.upper)) break;
    double sum = above;
    for (const Weighted& item : items) sum += item.weight * share_beyond(item.values, t);
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

AreaInterval quantile(double p, const TotalArea& area, const std::vector<WeightedEnclosure>& parts,
                      const AreaInterval& known, double resolution) {
  constexpr double kRound = 2 * rounding::kUnit;  // of 1 - p
  std::vector<Weighted> items;
  items.reserve(parts.size());
  const auto share = [&](double sum) { return area.share({sum, sum, false, false}); };
  for (const WeightedEnclosure& part : parts) items.push_back({part.enclosure.high, part.weight});
  const double upper =
      bisect(items, known, resolution, [&](double sum) { return !(share(sum).upper <= 1 - p - kRound); }).upper;
  items.clear();
  for (const WeightedEnclosure& part : parts) items.push_back({part.enclosure.low, part.weight});
  const double lower = bisect(items, {known.lower, upper}, resolution, [&](double sum) {
                         return share(sum).lower > 1 - p + kRound;
                       }).lower;
  return {lower, upper};
}

}  // namespace meshgauge
