#include "engine/tree/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/kernels/flat.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBlocksATask = 512;                   // about 0.2 ms
constexpr std::size_t kNodesACheck = std::size_t{1} << 13;  // less than 2 ms
constexpr std::size_t kNodesATask = 512;                    // less than 0.2 ms
constexpr int kBins = 16;
// Below this depth splits are at the median: the surface area heuristic may peel off a leaf at a time on hostile input
// (sizes in geometric progression), and a path must fit kMaxTreeDepth.
constexpr std::uint32_t kHeuristicDepth = 56;
constexpr std::size_t kTreeATask = 1024;                   // leaves, about 0.2 ms
constexpr std::size_t kCheckEvery = std::size_t{1} << 15;  // items between two checks of the clock, less than 1 ms

using Vec3f = Eigen::Array3f;

struct FloatBox {
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity());
  Vec3f high = Vec3f::Constant(-std::numeric_limits<float>::infinity());
  void extend(const FloatBox& b) {
    low = low.min(b.low);
    high = high.max(b.high);
  }
};

// A leaf while it is sorted into the tree. Its box is in float because it only decides where to split, never what a box
// holds. Items are moved as a whole, so that the passes over a range read memory in order.
struct Item {
  FloatBox box;
  std::uint32_t leaf;
  float centre(int axis) const { return box.low[axis] + box.high[axis]; }  // twice the centre
};

struct Range {
  std::uint32_t begin;
  std::uint32_t end;
  float area;
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

// Moves the items for which `is_left` holds to the front and returns their number. As std::partition, which leaves open
// in what order the items then are.
template <class IsLeft>
std::size_t partition_by(std::span<Item> items, IsLeft is_left) {
  std::size_t left = 0;
  for (std::size_t right = items.size();;) {
    while (left < right && is_left(items[left])) ++left;
    while (left < right && !is_left(items[right - 1])) --right;
    if (left == right) return left;
    std::swap(items[left++], items[--right]);
  }
}

// Splits at the median of the exact centres, for ranges far from the frame's centre that float cannot resolve.
std::size_t split_at_median(std::span<const Box> leaves, std::span<Item> items) {
  const auto centre = [&](const Item& item) { return Vec3(leaves[item.leaf].low + leaves[item.leaf].high); };
  Box box;
  for (const Item& item : items) box.extend(centre(item));
  int axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  // The keys alone by nth_element(), which leaves open in what order the others then are.
  const auto key = [&](const Item& item) { return std::pair(centre(item)[axis], item.leaf); };
  std::vector<std::pair<double, std::uint32_t>> keys;
  keys.reserve(items.size());
  for (const Item& item : items) keys.push_back(key(item));
  const auto median = keys.begin() + static_cast<std::ptrdiff_t>(keys.size() / 2);
  std::nth_element(keys.begin(), median, keys.end());
  return partition_by(items, [&](const Item& item) { return key(item) < *median; });
}

// Whether bins would be narrower than a few units of float.
bool too_fine_for_float(const FloatBox& centres) {
  const float magnitude = centres.low.abs().max(centres.high.abs()).maxCoeff();
  return (centres.high - centres.low).maxCoeff() < magnitude * (8 * kBins * std::numeric_limits<float>::epsilon());
}

// Moves the items of the left half to the front and returns their number.
std::size_t partition(std::span<const Box> leaves, std::span<Item> items, std::uint32_t depth) {
  const FloatBox centres = box_of_centres(items);
  if (depth >= kHeuristicDepth || too_fine_for_float(centres)) return split_at_median(leaves, items);
  const Split split = best_split(items, centres);
  if (split.bin < 0) return split_at_median(leaves, items);
  return partition_by(items, [&](const Item& item) { return split.bin_of(item) < split.bin; });
}

std::vector<Item> items_of(std::span<const Box> leaves) {
  std::vector<Item> items(leaves.size());
  for (std::uint32_t i = 0; i < items.size(); ++i) {
    items[i] = {{leaves[i].low.cast<float>().array(), leaves[i].high.cast<float>().array()}, i};
  }
  return items;
}

float half_area(std::span<const Item> items) {
  FloatBox box;
  for (const Item& item : items) box.extend(item.box);
  return half_area(box);
}

// A node to make.
struct Task {
  std::uint32_t node;
  Range range;
  std::uint32_t depth;  // of the node, in nodes
};

// Makes the nodes over a range of the leaves; does not touch other items.
class Splitter {
 public:
  // `items`: those of all leaves. Tasks of at most `smallest` items are put aside, not split.
  Splitter(std::span<const Box> leaves, std::span<Item> items, std::size_t smallest, Control& control)
      : leaves_(leaves), items_(items), smallest_(smallest), control_(control) {}

  // Makes the nodes; the root is node 0. False: interrupted.
  bool run(const Range& range, std::uint32_t depth) {
    nodes_.reserve(range.size() / 4 + 1);
    nodes_.emplace_back();
    std::vector<Task> open{{0, range, depth}};
    while (!open.empty() && !interrupted_) {
      const Task task = open.back();
      open.pop_back();
      if (task.range.size() > smallest_) {
        fill(task, open);
      } else {
        put_aside_.push_back(task);
      }
    }
    return !interrupted_;
  }

  const std::vector<Task>& put_aside() const { return put_aside_; }

  // Takes over the nodes of a tree made for a task that was put aside.
  void attach(const Task& task, const LargeArray<WideNode>& tree) {
    const auto base = static_cast<std::uint32_t>(nodes_.size() - 1);  // node 0 of `tree` takes the place of task.node
    for (std::size_t n = 0; n < tree.size(); ++n) {
      WideNode node = tree[n];
      for (std::uint32_t& child : node.child) {
        if (child != WideNode::kNone && !(child & WideNode::kLeaf)) child += base;
      }
      if (n == 0) {
        nodes_[task.node] = node;
      } else {
        nodes_.push_back(node);
      }
    }
  }

  LargeArray<WideNode> take_nodes() { return std::move(nodes_); }

 private:
  // Splits the child with the largest surface until there are eight children or each fits one node; then replaces the
  // smallest children by their leaves while there is room.
  void fill(const Task& task, std::vector<Task>& open) {
    std::array<Range, kLanes> children{task.range};
    std::size_t count = 1;
    const auto split = [&](Range& range) {
      check_clock(range.size());
      const std::size_t left = partition(leaves_, part(range), task.depth);
      const auto middle = range.begin + static_cast<std::uint32_t>(left);
      children[count++] = measured(middle, range.end);
      range = measured(range.begin, middle);
    };
    while (count < kLanes && !interrupted_) {
      Range& widest = *std::max_element(children.begin(), children.begin() + count, narrower);
      if (widest.size() <= kLanes) break;
      split(widest);
    }
    while (count < kLanes) {
      Range& smallest = *std::min_element(children.begin(), children.begin() + count, easier_to_dissolve);
      if (smallest.size() == 1 || count + smallest.size() - 1 > kLanes) break;
      const Range range = smallest;
      smallest = {range.begin, range.begin + 1, 0};
      for (std::uint32_t i = range.begin + 1; i < range.end; ++i) children[count++] = {i, i + 1, 0};
    }
    nodes_[task.node] = WideNode{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (lane >= count) {
        nodes_[task.node].child[lane] = WideNode::kNone;
      } else if (children[lane].size() == 1) {
        nodes_[task.node].child[lane] = WideNode::kLeaf | items_[children[lane].begin].leaf;
      } else {
        const auto child = static_cast<std::uint32_t>(nodes_.size());
        nodes_[task.node].child[lane] = child;
        nodes_.emplace_back();
        open.push_back({child, children[lane], task.depth + 1});
      }
    }
  }

  void check_clock(std::size_t items) {
    if ((since_check_ += items) < kCheckEvery) return;
    since_check_ = 0;
    interrupted_ = control_.check() != Interruption::none;
  }
  // Ranges that fit a node come first: they need not be split.
  static bool narrower(const Range& a, const Range& b) {
    return std::pair(a.size() > kLanes, a.area) < std::pair(b.size() > kLanes, b.area);
  }
  // Single leaves come last: they are dissolved already.
  static bool easier_to_dissolve(const Range& a, const Range& b) {
    return std::pair(a.size() == 1, a.size()) < std::pair(b.size() == 1, b.size());
  }
  std::span<Item> part(const Range& range) { return items_.subspan(range.begin, range.size()); }
  Range measured(std::uint32_t begin, std::uint32_t end) {
    Range range{begin, end, 0};
    range.area = half_area(part(range));
    return range;
  }

  std::span<const Box> leaves_;
  std::span<Item> items_;
  std::size_t smallest_;
  Control& control_;
  LargeArray<WideNode> nodes_;
  std::vector<Task> put_aside_;
  std::size_t since_check_ = 0;
  bool interrupted_ = false;
};

// Returns the nodes over leaves with these boxes, by the surface area heuristic from the top down. Node 0 is the root,
// parents come before their children, no path is longer than kMaxTreeDepth. Only child[lane] is set, not the boxes. The
// result does not depend on the pool: the large nodes are made on this thread, then the trees below them in parallel.
// Empty: interrupted.
LargeArray<WideNode> split_wide(std::span<const Box> leaves, Control& control, ThreadPool& pool) {
  std::vector<Item> items = items_of(leaves);
  Splitter top(leaves, items, kTreeATask, control);
  if (!top.run({0, static_cast<std::uint32_t>(items.size()), 0}, 0)) return {};
  std::vector<LargeArray<WideNode>> trees(top.put_aside().size());
  pool.run(trees.size(), [&](std::size_t, std::size_t i) {
    if (control.check() != Interruption::none) return;
    const Task& task = top.put_aside()[i];
    Splitter below(leaves, items, 0, control);
    if (below.run(task.range, task.depth)) trees[i] = below.take_nodes();
  });
  for (std::size_t i = 0; i < trees.size(); ++i) {
    if (trees[i].empty() || control.check() != Interruption::none) return {};
    top.attach(top.put_aside()[i], std::exchange(trees[i], {}));
  }
  return top.take_nodes();
}

// Stores a box on one axis as offsets from `origin` in single precision, widened by `pad`: rounding.h R6.
void store_offsets(const Box& box, int axis, double origin, double pad, WideNode& node, std::size_t lane) {
  node.low[axis][lane] = rounding::float_down(box.low[axis] - origin - pad);
  node.high[axis][lane] = rounding::float_up(box.high[axis] - origin + pad);
}

void store_empty(WideNode& node, std::size_t lane) {
  for (auto& low : node.low) low[lane] = std::numeric_limits<float>::infinity();
  for (auto& high : node.high) high[lane] = -std::numeric_limits<float>::infinity();
}

}  // namespace

Bvh::Bvh(MeshView mesh, const Kernels& kernels, Control& control, ThreadPool& pool) : mesh_(mesh), kernels_(&kernels) {
  const std::vector<Box> block_boxes = prepare_blocks(control, pool);
  if (block_boxes.empty()) return;
  nodes_ = split_wide(block_boxes, control, pool);
  if (!fit_boxes(block_boxes, control, pool)) nodes_.clear();
}

// Returns the boxes of the blocks. Empty: interrupted.
std::vector<Box> Bvh::prepare_blocks(Control& control, ThreadPool& pool) {
  const std::size_t triangles = mesh_.triangles.size();
  const std::size_t count = (triangles + kLanes - 1) / kLanes;
  blocks_.resize(count);
  std::vector<Box> boxes(count);
  std::vector<double> residuals(pool.size(), 0.0);
  const auto prepare_block = [&](std::size_t worker, std::size_t b) {
    std::array<PointBlock, 3> corners;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t t = std::min(b * kLanes + lane, triangles - 1);
      for (int i = 0; i < 3; ++i) {
        const Vec3& p = mesh_.corner(t, i);
        boxes[b].extend(p);
        for (int k = 0; k < 3; ++k) corners[static_cast<std::size_t>(i)].at[k][lane] = p[k];
      }
    }
    residuals[worker] = std::max(residuals[worker], kernels_->prepare(corners.data(), blocks_[b]));
  };
  const std::size_t round = kBlocksATask * pool.size() * 4;
  for (std::size_t begin = 0; begin < count; begin += round) {
    if (control.check() != Interruption::none) return {};
    const std::size_t end = std::min(begin + round, count);
    pool.run((end - begin + kBlocksATask - 1) / kBlocksATask, [&](std::size_t worker, std::size_t task) {
      const std::size_t first = begin + task * kBlocksATask;
      for (std::size_t b = first; b < std::min(first + kBlocksATask, end); ++b) prepare_block(worker, b);
    });
  }
  residual_ = *std::max_element(residuals.begin(), residuals.end()) + rounding::kResidualSlack;
  return boxes;
}

// False: interrupted.
bool Bvh::fit_boxes(std::span<const Box> block_boxes, Control& control, ThreadPool& pool) {
  std::vector<Box> node_boxes(nodes_.size());
  const auto box_of = [&](std::uint32_t child) -> const Box& {
    return child & WideNode::kLeaf ? block_boxes[child & ~WideNode::kLeaf] : node_boxes[child];
  };
  for (std::size_t n = nodes_.size(); n-- > 0;) {  // bottom up: children come after their parent
    if (n % kNodesACheck == kNodesACheck - 1 && control.check() != Interruption::none) return false;
    for (const std::uint32_t child : nodes_[n].child) {
      if (child != WideNode::kNone) node_boxes[n].extend(box_of(child));
    }
  }
  const auto fit = [&](WideNode& node, const Box& box) {
    const Vec3 origin = (box.low + box.high) * 0.5;
    const Vec3 reach = (box.high - origin).cwiseMax(origin - box.low);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (node.child[lane] == WideNode::kNone) {
        store_empty(node, lane);
        continue;
      }
      const Box& child = box_of(node.child[lane]);
      for (int k = 0; k < 3; ++k) store_offsets(child, k, origin[k], rounding::kOffsetPad * reach[k], node, lane);
    }
    for (int k = 0; k < 3; ++k) node.origin[k] = origin[k];
    node.reach = rounding::float_up(reach.maxCoeff());
  };
  const Interrupted interrupted = [&control] { return control.check() != Interruption::none; };
  return each_range(interrupted, nodes_.size(), kNodesATask, pool, [&](std::size_t first, std::size_t last) {
    for (std::size_t n = first; n < last; ++n) fit(nodes_[n], node_boxes[n]);
  });
}

// The offsets are rounded outwards, and addition rounds monotonically: the box holds every coordinate below it.
Box Bvh::child_box(const WideNode& node, std::size_t lane) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = node.origin[k] + static_cast<double>(node.low[k][lane]);
    box.high[k] = node.origin[k] + static_cast<double>(node.high[k][lane]);
  }
  return box;
}

PreparedTriangle Bvh::prepared(std::uint32_t triangle) const {
  const FlatTriangle t = flat(blocks_[triangle / kLanes], triangle % kLanes);
  return {Vec3(t.a[0], t.a[1], t.a[2]),
          Vec3(t.e1[0], t.e1[1], t.e1[2]),
          Vec3(t.e2[0], t.e2[1], t.e2[2]),
          t.length,
          t.cx,
          t.cy};
}

}  // namespace meshgauge
