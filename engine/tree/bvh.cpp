#include "engine/tree/bvh.h"

#include <algorithm>
#include <cmath>

#include "engine/kernels/flat.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"
#include "engine/tree/bvh_split.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBlocksATask = 512;                   // about 0.2 ms
constexpr std::size_t kNodesACheck = std::size_t{1} << 13;  // less than 2 ms
constexpr std::size_t kNodesATask = 512;                    // less than 0.2 ms

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
