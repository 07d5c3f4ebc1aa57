#include "engine/sweep.h"

#include <algorithm>
#include <vector>

#include "engine/bounds/lipschitz.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBlockSize = 64;  // triangles; some 0.1 ms at most

// Neighbouring triangles, looked at together first.
struct Block {
  std::size_t begin = 0;  // in the order
  std::size_t end = 0;
  double upper = 0;  // of h(block, B), computed
};

class Sweep {
 public:
  explicit Sweep(Search& search)
      : search_(search),
        vertices_(search.from().positions.size()) {}

  std::optional<Stop> run() {
    if (const auto stop = bound_blocks()) return give_up(stop);
    // Largest bound first: what is not visited yet is bounded by the block at hand, and soon the rest can be dropped at
    // once.
    std::sort(blocks_.begin(), blocks_.end(), [](const Block& a, const Block& b) {
      return std::pair(-a.upper, a.begin) < std::pair(-b.upper, b.begin);
    });
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      search_.set_unvisited(blocks_[i].upper);
      if (const auto stop = search_.pulse()) return give_up(stop);
      if (search_.over_budget()) return give_up(Stop::budget);
      if (blocks_[i].upper <= search_.cull_within_tolerance()) {
        search_.drop(blocks_[i].upper);
        break;
      }
      for (std::size_t k = blocks_[i].begin; k < blocks_[i].end; ++k) visit(static_cast<std::uint32_t>(k), blocks_[i].upper);
    }
    search_.keep_above(search_.cull_within_tolerance());  // the lower bound has risen since the first of them survived
    search_.culling().survivors = search_.waiting();
    search_.set_unvisited(0);
    return std::nullopt;
  }

 private:
  struct Vertex {
    double distance = -1;                 // negative: not measured
    std::uint32_t slot = Nearest::kNone;  // nearest if measured, else one that a neighbour used
  };

  // eq. 4/5 for each block's box, and the distance of one of its vertices: that sample gives most of the final lower
  // bound.
  std::optional<Stop> bound_blocks() {
    for (std::size_t begin = 0; begin < search_.from().triangles.size(); begin += kBlockSize) {
      if (const auto stop = search_.pulse()) return stop;
      Block block{begin, std::min(begin + kBlockSize, search_.from().triangles.size()), 0};
      Box box;
      for (std::size_t k = block.begin; k < block.end; ++k) {
        for (int i = 0; i < 3; ++i) box.extend(search_.from().corner(static_cast<std::uint32_t>(k), i));
      }
      measure(search_.from().triangles[static_cast<std::uint32_t>(begin)][0], static_cast<std::uint32_t>(begin));
      ++search_.work().nearest_queries;
      const Vec3 centre = (box.low + box.high) * 0.5;
      const Nearest found = nearest(search_.to(), centre, search_.work().triangle_tests, last_);
      block.upper = farthest_of_box(box, found.point);
      blocks_.push_back(block);
    }
    return std::nullopt;
  }

  // Stopped early: the rest stays unvisited.
  std::optional<Stop> give_up(std::optional<Stop> stop) {
    search_.culling().survivors = search_.waiting() + (search_.from().triangles.size() - visited_);
    return stop;
  }

  void visit(std::uint32_t t, double block_upper) {
    const Triangle& triangle = search_.from().triangles[t];
    Piece piece;
    piece.triangle = t;
    ++visited_;
    for (std::size_t i = 0; i < 3; ++i) piece.corners[i].point = search_.from().positions[triangle[i]];
    if (culled_by_neighbours(piece, triangle)) return;
    for (std::size_t i = 0; i < 3; ++i) piece.corners[i] = measure(triangle[i], t);
    piece.upper = std::min({block_upper, lipschitz_upper(piece), owners_upper(piece)});
    if (piece.upper <= search_.cull_within_tolerance()) return search_.drop(piece.upper);
    const Vec3 centroid = (piece.corners[0].point + piece.corners[1].point + piece.corners[2].point) / 3;
    last_ = nearest_corner(search_.to(), centroid, search_.work(), piece.corners[0].slot).slot;
    piece.upper = std::min(piece.upper, certificate(piece, last_, piece.upper));
    if (piece.upper <= search_.cull_within_tolerance()) return search_.drop(piece.upper);
    search_.push(piece);
  }

  bool culled_by_neighbours(const Piece& piece, const Triangle& triangle) {
    const std::array hints{last_, vertices_[triangle[0]].slot, vertices_[triangle[1]].slot,
                           vertices_[triangle[2]].slot};
    const double limit = search_.cull_within_tolerance();
    for (auto it = hints.begin(); it != hints.end(); ++it) {
      if (*it == Nearest::kNone || std::find(hints.begin(), it, *it) != it) continue;
      const double upper = certificate(piece, *it, std::nextafter(limit, 10.0));
      if (upper > limit) continue;
      search_.drop(upper);
      last_ = *it;
      for (const std::uint32_t v : triangle) {
        if (vertices_[v].distance < 0) vertices_[v].slot = *it;
      }
      return true;
    }
    return false;
  }

  double certificate(const Piece& piece, std::uint32_t slot, double limit) {
    search_.work().triangle_tests += 3;
    return farthest_corner(piece, search_.to().prepared(slot), limit);
  }

  double owners_upper(const Piece& piece) {
    const auto& [a, b, c] = piece.corners;
    return least_farthest(piece, search_.to(), std::array{a.slot, b.slot, c.slot}, search_.work());
  }

  Corner measure(std::uint32_t v, std::uint32_t triangle) {
    Vertex& vertex = vertices_[v];
    const Vec3& p = search_.from().positions[v];
    if (vertex.distance >= 0) {
      ++search_.work().cache_hits;
      return {p, vertex.distance, vertex.slot};
    }
    const Corner corner =
        nearest_corner(search_.to(), p, search_.work(), vertex.slot != Nearest::kNone ? vertex.slot : last_);
    vertex = {corner.distance, corner.slot};
    last_ = corner.slot;
    search_.saw(corner, triangle, true);
    return corner;
  }

  Search& search_;
  std::vector<Block> blocks_;
  std::size_t visited_ = 0;  // triangles
  std::vector<Vertex> vertices_;
  std::uint32_t last_ = Nearest::kNone;  // triangle of B that served last
};

}  // namespace

std::optional<Stop> sweep(Search& search) { return Sweep(search).run(); }

}  // namespace meshgauge
