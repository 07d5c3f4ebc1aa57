#include "engine/paper/reduction.h"

#include "engine/rounding.h"

namespace meshgauge {
namespace {

Vec3 midpoint(const Corner& a, const Corner& b) { return (a.point + b.point) * 0.5; }

double longest_edge(const Piece& piece) {
  const auto& [a, b, c] = piece.corners;
  return std::max({norm(a.point - b.point), norm(b.point - c.point), norm(c.point - a.point)});
}

// The bound of a piece that is smaller than rounding can resolve: d(., B) is 1-Lipschitz, so no point of the piece is
// farther from B than a corner's distance plus the piece's size. That is below lower + kSmallestGap.
double unsplittable_upper(const Piece& piece, double size) {
  double farthest = 0;
  for (const Corner& corner : piece.corners) farthest = std::max(farthest, corner.distance);
  return std::min(piece.upper, farthest + size);
}

class Reduction {
 public:
  Reduction(Search& search, PieceBound& bound) : search_(search), bound_(bound) {}

  void split(const Piece& piece) {
    if (const double size = longest_edge(piece); size < rounding::kSmallestPiece) {
      return search_.drop(unsplittable_upper(piece, size));
    }
    ++search_.work().subdivisions;
    search_.work().max_depth = std::max(search_.work().max_depth, piece.depth + 1);
    const auto& [a, b, c] = piece.corners;
    const Corner ab = measure(midpoint(a, b), piece);
    const Corner bc = measure(midpoint(b, c), piece);
    const Corner ca = measure(midpoint(c, a), piece);
    add({a, ab, ca}, piece);
    add({ab, b, bc}, piece);
    add({ca, bc, c}, piece);
    add({ab, bc, ca}, piece);
  }

 private:
  Corner measure(const Vec3& p, const Piece& parent) {
    const Corner corner = bound_.measure(p, parent);
    search_.observe(corner, parent.triangle, false);
    return corner;
  }

  // A part lies in its parent, so the parent's bound holds for it too.
  void add(const std::array<Corner, 3>& corners, const Piece& parent) {
    Piece part{corners, parent.upper, parent.triangle, parent.depth + 1};
    part.upper = std::min(parent.upper, bound_.upper(part));
    if (part.upper <= search_.cull_below()) return search_.drop(part.upper);
    search_.push(part);
  }

  Search& search_;
  PieceBound& bound_;
};

}  // namespace

std::optional<Stop> reduce(Search& search, PieceBound& bound) {
  Reduction reduction(search, bound);
  while (!search.empty() && !search.reached_goal()) {
    if (const auto stop = search.pulse()) return stop;
    if (search.over_budget(bound.memory_bytes())) return Stop::budget;
    reduction.split(search.pop());
  }
  return std::nullopt;
}

}  // namespace meshgauge
