#include "engine/paper/traversal.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace meshgauge {
namespace {

struct OpenNode {
  std::uint32_t child;  // as in WideNode: a node or a block
  double upper;         // of h(node, B)
};

class Traversal {
 public:
  Traversal(Search& search, const Bvh& from, PieceBound& bound)
      : search_(search), from_(from), bound_(bound), cache_(search.from().positions.size()) {}

  std::optional<Stop> run() {
    open_.push_back({Bvh::kRoot, search_.upper()});
    while (!open_.empty()) {
      auto stop = search_.pulse();
      if (!stop && search_.over_budget(bound_.memory_bytes())) stop = Stop::budget;
      if (stop) {
        account_for_unvisited();
        return stop;
      }
      const OpenNode entry = open_.back();
      open_.pop_back();
      visit(entry);
    }
    search_.set_unvisited(0);
    return std::nullopt;
  }

 private:
  // Visits the child with the largest bound first: it is the most likely to raise the lower bound.
  void visit(const OpenNode& entry) {
    if (entry.upper <= search_.cull_below()) return search_.drop(entry.upper);
    if (entry.child & WideNode::kLeaf) {
      const std::uint32_t block = entry.child & ~WideNode::kLeaf;
      for (std::uint32_t t = Bvh::block_begin(block); t < from_.block_end(block); ++t) {
        visit_triangle(t, entry.upper);
      }
      return;
    }
    const WideNode& node = from_.nodes()[entry.child];
    const auto first = static_cast<std::ptrdiff_t>(open_.size());
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (node.child[lane] == WideNode::kNone) continue;
      open_.push_back({node.child[lane], std::min(entry.upper, box_upper(Bvh::child_box(node, lane)))});
    }
    std::stable_sort(open_.begin() + first, open_.end(),
                     [](const OpenNode& a, const OpenNode& b) { return a.upper < b.upper; });
  }

  // An upper bound of h(node, B), eq. 4/5: the distance from b, the point of B nearest to the box's centre, to the
  // farthest corner of the box. No point of the box is farther from b.
  double box_upper(const Box& box) {
    ++search_.work().nearest_queries;
    const Vec3 b =
        nearest(search_.to(), (box.low + box.high) * 0.5, search_.work().triangle_tests, Nearest::kNone, search_.stop())
            .point;
    return farthest_of_box(box, b);
  }

  void visit_triangle(std::uint32_t triangle, double node_upper) {
    Piece piece;
    piece.triangle = triangle;
    for (int i = 0; i < 3; ++i) {
      const Corner& corner = measure_vertex(search_.from().triangles[triangle][static_cast<std::size_t>(i)]);
      piece.corners[static_cast<std::size_t>(i)] = corner;
      search_.observe(corner, triangle, true);  // eq. 6
    }
    piece.upper = std::min(node_upper, bound_.upper(piece));
    if (piece.upper <= search_.cull_below()) return search_.drop(piece.upper);
    ++search_.survivors();
    search_.push(piece);
  }

  const Corner& measure_vertex(std::uint32_t vertex) {
    Corner& corner = cache_[vertex];
    if (corner.slot != Nearest::kNone) {
      ++search_.work().cache_hits;
      return corner;
    }
    return corner = nearest_corner(search_.to(), search_.from().positions[vertex], search_.work(), search_.stop());
  }

  void account_for_unvisited() {
    double upper = 0;
    for (const OpenNode& entry : open_) {
      upper = std::max(upper, entry.upper);
      search_.survivors() += triangles_below(entry.child);
    }
    search_.set_unvisited(upper);
  }

  std::size_t triangles_below(std::uint32_t top) const {
    std::size_t count = 0;
    std::vector<std::uint32_t> stack{top};
    while (!stack.empty()) {
      const std::uint32_t child = stack.back();
      stack.pop_back();
      if (child == WideNode::kNone) continue;
      if (child & WideNode::kLeaf) {
        const std::uint32_t block = child & ~WideNode::kLeaf;
        count += from_.block_end(block) - Bvh::block_begin(block);
      } else {
        const auto& children = from_.nodes()[child].child;
        stack.insert(stack.end(), std::begin(children), std::end(children));
      }
    }
    return count;
  }

  Search& search_;
  const Bvh& from_;
  PieceBound& bound_;
  std::vector<Corner> cache_;
  std::vector<OpenNode> open_;
};

}  // namespace

std::optional<Stop> traverse(Search& search, const Bvh& from, PieceBound& bound) {
  return Traversal(search, from, bound).run();
}

}  // namespace meshgauge
