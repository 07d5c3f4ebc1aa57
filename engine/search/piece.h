// A piece of A, which is a triangle of A or a part of one, and the interface of the bounds of its distance from B.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "engine/outcome.h"
#include "engine/tree/nearest.h"

namespace meshgauge {

// A measured point of A.
struct Corner {
  Vec3 point = Vec3::Zero();            // unit frame
  double distance = 0;                  // d(point, B), computed
  std::uint32_t slot = Nearest::kNone;  // the nearest triangle of B, in its tree's mesh
  // False: the query was stopped. `distance` is that from triangle `slot`: an upper bound of d(point, B), which may not
  // raise a lower bound.
  bool complete = true;
};

struct Piece {
  std::array<Corner, 3> corners;
  double upper = 0;             // computed upper bound of h(piece, B), without slack
  std::uint32_t triangle = 0;   // the triangle of A that holds the piece
  std::uint32_t depth = 0;      // subdivisions since the whole triangle
  bool overlay_failed = false;  // the overlay bound failed or would fail: do not try it again
};

// The bound of one of the paper's strategies. One object for each search; not thread safe.
class PieceBound {
 public:
  PieceBound() = default;
  PieceBound(const PieceBound&) = delete;
  PieceBound& operator=(const PieceBound&) = delete;
  virtual ~PieceBound() = default;

  // Measures d(p, B) for a new corner p of a part of `parent`.
  virtual Corner measure(const Vec3& p, const Piece& parent) = 0;

  // Returns an upper bound of h(piece, B), computed from the piece's corners: rounding.h R3 and R4 give its slack.
  virtual double upper(const Piece& piece) = 0;

  // The strategy's own memory, which counts towards Options::max_memory_bytes.
  virtual std::size_t memory_bytes() const { return 0; }
};

// Queries the nearest triangle of a point and counts the query in `work`. `hint`, `stop` and `enough`: see nearest().
inline Corner nearest_corner(const Bvh& target, const Vec3& p, Work& work, const Interrupted* stop = nullptr,
                             std::uint32_t hint = Nearest::kNone, double enough = 0) {
  ++work.nearest_queries;
  const Nearest found = nearest(target, p, work.triangle_tests, hint, stop, enough);
  return {p, found.distance, found.slot, found.complete};
}

// The bound of eq. 9: max over the piece's corners v of d(v, T), for one triangle T of B. d(., T) is convex, so its
// maximum over the piece is at a corner: this bounds h(piece, T) and so h(piece, B). Computed: rounding.h R3.
class Certificate {
 public:
  Certificate(const std::array<Corner, 3>& corners, const Bvh& target) : target_(target) {
    for (int k = 0; k < 3; ++k) {
      double* const at = corners_.at[k];
      at[0] = at[3] = at[4] = at[5] = at[6] = at[7] = corners[0].point[k];
      at[1] = corners[1].point[k];
      at[2] = corners[2].point[k];
    }
  }

  // The bound for triangle `slot` of the target.
  double operator()(std::uint32_t slot, Work& work) const {
    work.triangle_tests += 3;
    return target_.farthest(corners_, slot);
  }

 private:
  const Bvh& target_;
  PointBlock corners_;
};

// Returns the bound of eq. 8: min over the candidates T of max over corners v of d(v, T). It bounds h(piece, B) for any
// set of candidates, because each of them does; so when `stop` ends it early, the bound is looser and holds. Infinite
// without candidates.
inline double least_farthest(const Piece& piece, const Bvh& target, std::span<const std::uint32_t> candidates,
                             Work& work, const Interrupted* stop = nullptr) {
  const Certificate certificate(piece.corners, target);
  double least = std::numeric_limits<double>::infinity();
  Polling polling(stop, work.triangle_tests);
  for (const std::uint32_t slot : candidates) {
    least = std::min(least, certificate(slot, work));
    if (polling.poll(work.triangle_tests)) break;
  }
  return least;
}

}  // namespace meshgauge
