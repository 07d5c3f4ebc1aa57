#include "engine/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace meshgauge {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr int kBins = 16;
// Below this depth splits are at the median: the surface area heuristic may peel off a triangle at a time on
// hostile input (sizes in geometric progression), and a path must fit kMaxDepth.
constexpr std::uint32_t kHeuristicDepth = 44;
constexpr std::size_t kCheckEvery = std::size_t{1} << 14;  // triangles between two looks at the clock, about 2 ms

using Vec3f = Eigen::Array3f;

struct FloatBox {
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity());
  Vec3f high = Vec3f::Constant(-std::numeric_limits<float>::infinity());
  void extend(const FloatBox& b) {
    low = low.min(b.low);
    high = high.max(b.high);
  }
};

// A triangle while it is sorted into the tree. In float: this decides only where to split, never what a box holds.
// Moved around as a whole, so that the passes over a range read memory in order.
struct Item {
  FloatBox box;
  std::uint32_t triangle;
  float centre(int axis) const { return box.low[axis] + box.high[axis]; }  // twice the centre
};

struct Range {
  std::uint32_t node;
  std::uint32_t begin;
  std::uint32_t end;
  std::uint32_t depth;
  std::uint32_t size() const { return end - begin; }
};

// Half of the surface, plus a trace of the size so that collinear input is split sensibly too.
float half_area(const FloatBox& box) {
  const Vec3f d = box.high - box.low;
  return d[0] * d[1] + d[1] * d[2] + d[2] * d[0] + 1e-6F * (d[0] + d[1] + d[2]);
}

int longest_axis(const FloatBox& box) {
  const Vec3f d = box.high - box.low;
  return d[0] >= d[1] && d[0] >= d[2] ? 0 : d[1] >= d[2] ? 1 : 2;
}

struct Split {
  int axis = 0;
  int bin = -1;  // items of bins below this go left; -1: no useful split
  float low = 0;
  float scale = 0;
  int bin_of(const Item& item) const {
    return std::clamp(static_cast<int>((item.centre(axis) - low) * scale), 0, kBins - 1);
  }
};

FloatBox box_of_centres(std::span<const Item> items) {
  FloatBox box;
  for (const Item& item : items) {
    const Vec3f centre = item.box.low + item.box.high;
    box.extend({centre, centre});
  }
  return box;
}

// The cheapest of kBins-1 cuts along the longest axis of the centres, by the surface area heuristic.
Split best_split(std::span<const Item> items, const FloatBox& centres) {
  Split split;
  split.axis = longest_axis(centres);
  split.low = centres.low[split.axis];
  split.scale = kBins / (centres.high[split.axis] - split.low);
  if (!std::isfinite(split.scale)) return split;  // all centres (almost) in one point

  std::array<FloatBox, kBins> boxes;
  std::array<std::uint32_t, kBins> counts{};
  for (const Item& item : items) {
    const auto bin = static_cast<std::size_t>(split.bin_of(item));
    boxes[bin].extend(item.box);
    ++counts[bin];
  }
  std::array<float, kBins> right_cost{};
  FloatBox right;
  std::uint32_t right_count = 0;
  for (std::size_t b = kBins - 1; b > 0; --b) {
    right.extend(boxes[b]);
    right_count += counts[b];
    right_cost[b] = right_count ? half_area(right) * static_cast<float>(right_count) : 0;
  }
  FloatBox left;
  std::uint32_t left_count = 0;
  float best = std::numeric_limits<float>::infinity();
  for (std::size_t b = 1; b < kBins; ++b) {
    left.extend(boxes[b - 1]);
    left_count += counts[b - 1];
    if (left_count == 0 || left_count == items.size()) continue;
    const float cost = half_area(left) * static_cast<float>(left_count) + right_cost[b];
    if (cost < best) best = cost, split.bin = static_cast<int>(b);
  }
  return split;
}

// Splits at the median of the true centres: for ranges that float cannot tell apart, far from the frame's centre.
std::size_t split_at_median(MeshView mesh, std::span<Item> items) {
  const auto centre = [&](const Item& item) {
    return Vec3(mesh.corner(item.triangle, 0) + mesh.corner(item.triangle, 1) + mesh.corner(item.triangle, 2));
  };
  Box box;
  for (const Item& item : items) box.extend(centre(item));
  int axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  const std::size_t middle = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
                   [&](const Item& i, const Item& j) {
                     return std::pair(centre(i)[axis], i.triangle) < std::pair(centre(j)[axis], j.triangle);
                   });
  return middle;
}

// Bins would be narrower than a few units of float.
bool too_fine_for_float(const FloatBox& centres) {
  const float magnitude = centres.low.abs().max(centres.high.abs()).maxCoeff();
  return (centres.high - centres.low).maxCoeff() < magnitude * (8 * kBins * std::numeric_limits<float>::epsilon());
}

// How many of the items go left, after moving them to the front.
std::size_t partition(MeshView mesh, std::span<Item> items, std::uint32_t depth) {
  const FloatBox centres = box_of_centres(items);
  if (depth >= kHeuristicDepth || too_fine_for_float(centres)) return split_at_median(mesh, items);
  const Split split = best_split(items, centres);
  if (split.bin < 0) return split_at_median(mesh, items);
  const auto middle =
      std::partition(items.begin(), items.end(), [&](const Item& item) { return split.bin_of(item) < split.bin; });
  return static_cast<std::size_t>(middle - items.begin());
}

std::vector<Item> items_of(MeshView mesh) {
  std::vector<Item> items(mesh.triangles.size());
  for (std::uint32_t t = 0; t < items.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3f p = mesh.corner(t, k).cast<float>();
      items[t].box.extend({p, p});
    }
    items[t].triangle = t;
  }
  return items;
}

}  // namespace

Bvh::Bvh(MeshView mesh, Control& control) : mesh_(mesh) {
  split(control);
  if (interruption_ == Interruption::none) prepare_all(control);
  if (interruption_ == Interruption::none) fit_boxes();
}

// Top down. Children come after their parent in nodes_.
void Bvh::split(Control& control) {
  std::vector<Item> items = items_of(mesh_);
  const auto n = static_cast<std::uint32_t>(items.size());
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
    if (range.size() <= kLeafSize) {
      nodes_[range.node].first = range.begin;
      nodes_[range.node].count = range.size();
      continue;
    }
    const auto left_size = partition(mesh_, std::span(items).subspan(range.begin, range.size()), range.depth);
    const std::uint32_t middle = range.begin + static_cast<std::uint32_t>(left_size);
    const auto left = static_cast<std::uint32_t>(nodes_.size());
    nodes_[range.node].first = left;
    nodes_.emplace_back();
    nodes_.emplace_back();
    open.push_back({left + 1, middle, range.end, range.depth + 1});
    open.push_back({left, range.begin, middle, range.depth + 1});
  }
  order_.reserve(n);
  for (const Item& item : items) order_.push_back(item.triangle);
}

void Bvh::prepare_all(Control& control) {
  prepared_.reserve(order_.size());
  for (std::uint32_t slot = 0; slot < order_.size(); ++slot) {
    if (slot % kCheckEvery == kCheckEvery - 1) {
      if (interruption_ = control.check(); interruption_ != Interruption::none) return;
    }
    const std::uint32_t t = order_[slot];
    const Preparation done = prepare(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2));
    prepared_.push_back(done.triangle);
    residual_ = std::max(residual_, done.residual);
  }
}

// Bottom up, from the vertices themselves: exact.
void Bvh::fit_boxes() {
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    if (!node->is_leaf()) {
      node->box = nodes_[node->first].box;
      node->box.extend(nodes_[node->first + 1].box);
      continue;
    }
    for (std::uint32_t slot = node->first; slot < node->first + node->count; ++slot) {
      for (int k = 0; k < 3; ++k) node->box.extend(mesh_.corner(order_[slot], k));
    }
  }
}

}  // namespace meshgauge
