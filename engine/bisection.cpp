#include "engine/bisection.h"

#include "engine/bounds/lipschitz.h"
#include "engine/bounds/overlay.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::size_t kSettled = 256;       // pieces without a new lower bound, after which the search goes depth first
constexpr std::size_t kMaxVisits = 64;      // triangles of B over one piece
constexpr std::size_t kWorthAdjacency = 8;  // pieces waiting from which the overlay pays for its adjacency

struct Longest {
  std::size_t edge = 0;  // from corner `edge` to the next
  double length = 0;
};

Longest longest_edge(const Piece& piece) {
  Longest best;
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = (piece.corners[i].point - piece.corners[(i + 1) % 3].point).norm();
    if (length > best.length) best = {i, length};
  }
  return best;
}

class Bisection {
 public:
  explicit Bisection(Search& search) : search_(search) {}

  std::optional<Stop> run() {
    std::size_t since_rise = 0;
    double last_lower = search_.lower();
    bool deep = false;
    while (!search_.empty()) {
      if (const auto stop = search_.pulse()) return stop;
      if (search_.over_budget()) return Stop::budget;
      treat(search_.pop());
      since_rise = search_.lower() > last_lower ? 0 : since_rise + 1;
      last_lower = search_.lower();
      if (!deep && since_rise > kSettled) {
        deep = true;
        search_.depth_first();
      }
    }
    return std::nullopt;
  }

 private:
  void treat(const Piece& piece) {
    if (piece.upper <= search_.cull_within_tolerance()) return search_.drop(piece.upper);
    if (const auto upper = overlay_upper(piece)) {
      return *upper > search_.cull_within_tolerance() ? search_.drop_unresolved(*upper) : search_.drop(*upper);
    }
    const Longest longest = longest_edge(piece);
    if (longest.length < rounding::kSmallestPiece) return search_.drop(std::min(piece.upper, lipschitz_upper(piece)));
    split(piece, longest.edge);
  }

  std::optional<double> overlay_upper(const Piece& piece) {
    if (!overlay_) {
      if (search_.waiting() < kWorthAdjacency) return std::nullopt;
      overlay_.emplace(search_.to());
    }
    const double limit = std::max(search_.cull_within_tolerance(), search_.lower() + rounding::kOverlayGap);
    return overlay_->upper(piece, limit, kMaxVisits, search_.work());
  }

  void split(const Piece& piece, std::size_t edge) {
    ++search_.work().subdivisions;
    search_.work().max_depth = std::max(search_.work().max_depth, piece.depth + 1);
    const Corner &a = piece.corners[edge], &b = piece.corners[(edge + 1) % 3], &c = piece.corners[(edge + 2) % 3];
    const Corner middle = nearest_corner(search_.to(), (a.point + b.point) * 0.5, search_.work(), a.slot);
    search_.saw(middle, piece.triangle, false);
    add({a, middle, c}, piece);
    add({middle, b, c}, piece);
  }

  void add(const std::array<Corner, 3>& corners, const Piece& parent) {
    Piece part{corners, parent.upper, parent.triangle, parent.depth + 1};
    part.upper = std::min(part.upper, lipschitz_upper(part));
    if (part.upper > search_.cull_within_tolerance()) {
      const std::array owners{corners[0].slot, corners[1].slot, corners[2].slot};
      part.upper = std::min(part.upper, least_farthest(part, search_.to(), owners, search_.work()));
    }
    if (part.upper <= search_.cull_within_tolerance()) return search_.drop(part.upper);
    search_.push(part);
  }

  Search& search_;
  std::optional<Overlay> overlay_;
};

}  // namespace

std::optional<Stop> bisect(Search& search) { return Bisection(search).run(); }

}  // namespace meshgauge
