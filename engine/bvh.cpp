#include "engine/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace meshgauge {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr int kBins = 16;
// Below this depth splits are at the median: the surface area heuristic may peel off a triangle at a time on
// hostile input (sizes in geometric progression), and a path must fit kMaxDepth.
constexpr std::uint32_t kHeuristicDepth = 44;
constexpr std::size_t kCheckEvery = std::size_t{1} << 14;  // triangles between two looks at the clock, about 2 ms

struct Item {
  Box box;
  Vec3 centre;
};

struct Range {
  std::uint32_t node;
  std::uint32_t begin;
  std::uint32_t end;
  std::uint32_t depth;
  std::uint32_t size() const { return end - begin; }
};

// Half of the surface, plus a trace of the size so that collinear input is split sensibly too.
double half_area(const Box& box) {
  const Vec3 d = box.high - box.low;
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x() + 1e-6 * d.sum();
}

struct Split {
  int axis = 0;
  int bin = -1;  // items of bins below this go left; -1: no useful split
  double low = 0;
  double scale = 0;
  int bin_of(const Vec3& centre) const {
    return std::clamp(static_cast<int>((centre[axis] - low) * scale), 0, kBins - 1);
  }
};

// The cheapest of kBins-1 cuts along the longest axis of the centres, by the surface area heuristic.
Split best_split(const std::vector<Item>& items, const std::vector<std::uint32_t>& order, const Range& range,
                 const Box& centres) {
  Split split;
  const Vec3 extent = centres.high - centres.low;
  extent.maxCoeff(&split.axis);
  split.low = centres.low[split.axis];
  split.scale = kBins / extent[split.axis];
  if (!std::isfinite(split.scale)) return split;  // all centres (almost) in one point

  std::array<Box, kBins> boxes;
  std::array<std::uint32_t, kBins> counts{};
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const Item& item = items[order[i]];
    const auto bin = static_cast<std::size_t>(split.bin_of(item.centre));
    boxes[bin].extend(item.box);
    ++counts[bin];
  }
  std::array<double, kBins> right_cost{};
  Box right;
  std::uint32_t right_count = 0;
  for (std::size_t b = kBins - 1; b > 0; --b) {
    right.extend(boxes[b]);
    right_count += counts[b];
    right_cost[b] = right_count ? half_area(right) * right_count : 0;
  }
  Box left;
  std::uint32_t left_count = 0;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t b = 1; b < kBins; ++b) {
    left.extend(boxes[b - 1]);
    left_count += counts[b - 1];
    if (left_count == 0 || left_count == range.size()) continue;
    const double cost = half_area(left) * left_count + right_cost[b];
    if (cost < best) best = cost, split.bin = static_cast<int>(b);
  }
  return split;
}

std::uint32_t partition(const std::vector<Item>& items, std::vector<std::uint32_t>& order, const Range& range) {
  Box centres;
  for (std::uint32_t i = range.begin; i < range.end; ++i) centres.extend(items[order[i]].centre);
  const Split split = range.depth < kHeuristicDepth ? best_split(items, order, range, centres) : Split{0, -1, 0, 0};
  const auto begin = order.begin() + range.begin;
  const auto end = order.begin() + range.end;
  if (split.bin >= 0) {
    const auto middle =
        std::partition(begin, end, [&](std::uint32_t i) { return split.bin_of(items[i].centre) < split.bin; });
    return static_cast<std::uint32_t>(middle - order.begin());
  }
  int axis = 0;
  (centres.high - centres.low).maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t i, std::uint32_t j) {
    return std::pair(items[i].centre[axis], i) < std::pair(items[j].centre[axis], j);
  });
  return static_cast<std::uint32_t>(middle - order.begin());
}

}  // namespace

Bvh::Bvh(MeshView mesh, Control& control) : mesh_(mesh) {
  const auto n = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<Item> items(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) items[i].box.extend(mesh.corner(i, k));
    items[i].centre = (items[i].box.low + items[i].box.high) * 0.5;
  }
  order_.resize(n);
  std::iota(order_.begin(), order_.end(), 0U);
  nodes_.reserve(n);
  nodes_.emplace_back();

  std::vector<Range> open{{kRoot, 0, n, 0}};
  std::size_t since_check = 0;
  while (!open.empty()) {
    const Range range = open.back();
    open.pop_back();
    if ((since_check += range.size()) >= kCheckEvery) {
      since_check = 0;
      if (interruption_ = control.check(); interruption_ != Interruption::none) return;
    }
    Box box;
    for (std::uint32_t i = range.begin; i < range.end; ++i) box.extend(items[order_[i]].box);
    nodes_[range.node].box = box;
    if (range.size() <= kLeafSize) {
      nodes_[range.node].first = range.begin;
      nodes_[range.node].count = range.size();
      continue;
    }
    const std::uint32_t middle = partition(items, order_, range);
    const auto left = static_cast<std::uint32_t>(nodes_.size());
    nodes_[range.node].first = left;
    nodes_.emplace_back();
    nodes_.emplace_back();
    open.push_back({left + 1, middle, range.end, range.depth + 1});
    open.push_back({left, range.begin, middle, range.depth + 1});
  }

  prepared_.reserve(n);
  for (std::uint32_t slot = 0; slot < n; ++slot) {
    if (slot % kCheckEvery == kCheckEvery - 1) {
      if (interruption_ = control.check(); interruption_ != Interruption::none) return;
    }
    const std::uint32_t t = order_[slot];
    const Preparation done = prepare(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    prepared_.push_back(done.triangle);
    residual_ = std::max(residual_, done.residual);
  }
}

}  // namespace meshgauge
