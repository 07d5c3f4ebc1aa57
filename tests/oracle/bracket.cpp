#include <algorithm>
#include <memory>

#include "oracle/farthest.h"

namespace meshgauge::oracle {
namespace {

// A point with its distances to all triangles; the pieces around it share it.
struct Measured {
  Point point;
  std::vector<Ratio> to_triangle_sq;
  Ratio nearest_sq() const { return *std::min_element(to_triangle_sq.begin(), to_triangle_sq.end()); }
};
using Vertex = std::shared_ptr<const Measured>;

struct Piece {
  std::array<Vertex, 3> corners;
  Ratio upper_sq;
  double order = 0;  // root of upper_sq, rounded: decides what is split next, nothing else
  bool operator<(const Piece& other) const { return order < other.order; }
};

class Search {
 public:
  Search(const Surface& from, const Surface& to) : to_(to) {
    for (const Corners& t : from) add({measure(t[0]), measure(t[1]), measure(t[2])});
  }

  void split_top() {
    std::pop_heap(pieces_.begin(), pieces_.end());
    const auto [a, b, c] = pieces_.back().corners;
    pieces_.pop_back();
    const Vertex ab = between(a, b), bc = between(b, c), ca = between(c, a);
    add({a, ab, ca});
    add({ab, b, bc});
    add({ca, bc, c});
    add({ab, bc, ca});
  }

  // Pieces below the lower bound are dropped, so the heap may become empty.
  Bracket bracket() const {
    Ratio upper_sq = lower_sq_;
    for (const Piece& piece : pieces_) upper_sq = std::max(upper_sq, piece.upper_sq);
    return {lower_sq_, upper_sq};
  }
  bool done() const { return pieces_.empty(); }

 private:
  Vertex measure(const Point& p) {
    Measured measured{p, {}};
    for (const Corners& t : to_) measured.to_triangle_sq.push_back(distance_sq(p, t));
    lower_sq_ = std::max(lower_sq_, measured.nearest_sq());
    return std::make_shared<const Measured>(std::move(measured));
  }

  Vertex between(const Vertex& a, const Vertex& b) {
    const Point sum = a->point + b->point;
    return measure({sum.x.half(), sum.y.half(), sum.z.half()});
  }

  void add(const std::array<Vertex, 3>& corners) {
    Piece piece{corners, worst_corner_sq(corners, 0), 0};
    for (std::size_t t = 1; t < to_.size(); ++t) piece.upper_sq = std::min(piece.upper_sq, worst_corner_sq(corners, t));
    if (piece.upper_sq <= lower_sq_) return;
    piece.order = piece.upper_sq.approximate_root();
    pieces_.push_back(std::move(piece));
    std::push_heap(pieces_.begin(), pieces_.end());
  }

  static Ratio worst_corner_sq(const std::array<Vertex, 3>& corners, std::size_t t) {
    return std::max({corners[0]->to_triangle_sq[t], corners[1]->to_triangle_sq[t], corners[2]->to_triangle_sq[t]});
  }

  const Surface& to_;
  Ratio lower_sq_{0.0, 1.0};
  std::vector<Piece> pieces_;
};

}  // namespace

Bracket exact_bracket(const Surface& from, const Surface& to, std::size_t max_splits) {
  Search search(from, to);
  for (std::size_t i = 0; i < max_splits && !search.done(); ++i) search.split_top();
  return search.bracket();
}

}  // namespace meshgauge::oracle
