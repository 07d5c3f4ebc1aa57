#include "engine/extras/area/totals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr int kMostScaled = 900;  // a larger scale would enlarge what the frame lost of coordinates below 2^-1022

double root_up(double x) { return std::nextafter(std::sqrt(x), std::numeric_limits<double>::infinity()); }
double root_down(double x) { return std::max(std::nextafter(std::sqrt(x), 0.0), 0.0); }

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

AreaWeights::AreaWeights(const OrderedMesh& mesh, double error) : mesh_(mesh.view()) {
  const double width = (mesh.box.high - mesh.box.low).maxCoeff();
  const int exponent = width > 0 ? std::ilogb(width) : 0;
  scale_ = std::ldexp(1.0, std::clamp(-exponent, 0, kMostScaled));
  moved_ = 2 * error * scale_;
}

AreaWeights::Weight AreaWeights::of(std::size_t triangle) const {
  const Vec3 x = (mesh_.corner(triangle, 1) - mesh_.corner(triangle, 0)) * scale_;
  const Vec3 y = (mesh_.corner(triangle, 2) - mesh_.corner(triangle, 0)) * scale_;
  const double lengths = norm(x) + norm(y);
  const double error =
      rounding::kAreaSlack * (norm(x) * norm(y)) + (moved_ + rounding::kAreaOffset) * lengths + moved_ * moved_;
  const double area = norm(x.cross(y));
  return {std::max(area - error, 0.0), 2 * (error + rounding::kAreaOffset * rounding::kAreaOffset)};
}

// With areas a = w + e, 0 <= e, sum e <= error, and values x in [0, most]: sum a x / sum a is largest when all of the
// error has the value `most`, and then at most (sum w x + error * most) / sum w; it is at least
// sum w x / (sum w + error). Cells (part.h) add cell_error * most to the former sum and take it from the latter.
AreaInterval TotalArea::average(double low, double high, double most) const {
  if (none()) return {0, most};
  const double off = 2 * rounding::sum_error(terms) + rounding::kMeanSlack;
  const double cells = cell_error * most * (1 + 0x1p-20);  // the sum of at most 2^32 errors
  const double upper = (high + cells + error * most) / weight * (1 + off);
  const double lower = (low * (1 - off) - cells) / (weight + error) * (1 - off);
  return {std::clamp(lower, 0.0, most), std::clamp(upper, 0.0, most)};
}

AreaInterval TotalArea::share(const ShareSum& sum) const {
  if (sum.all_zero) return {0, 0};
  if (sum.all_one) return {1, 1};
  const AreaInterval rounded = average(sum.low, sum.high, 1);
  return {std::max(rounded.lower - rounding::kShareSlack, 0.0), std::min(rounded.upper + rounding::kShareSlack, 1.0)};
}

AreaInterval TotalArea::mean(const MeanSum& sum, double most) const { return average(sum.low, sum.high, most); }

AreaInterval TotalArea::rms(const MeanSum& sum, double most) const {
  const AreaInterval squares = average(sum.square_low, sum.square_high, rounding::add_up(most * most, 0));
  return {std::min(root_down(squares.lower), most), std::min(root_up(squares.upper), most)};
}

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
