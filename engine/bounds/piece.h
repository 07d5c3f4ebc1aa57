// A piece of A: a triangle of A or a part of one, and the interface by which a strategy bounds its distance to B.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "engine/nearest.h"
#include "engine/outcome.h"

namespace meshgauge {

struct Corner {
  Vec3 point = Vec3::Zero();            // unit frame
  double distance = 0;                  // d(point, B), computed
  std::uint32_t slot = Nearest::kNone;  // triangle of B, in its tree's mesh, that is nearest
};

struct Piece {
  std::array<Corner, 3> corners;
  double upper = 0;             // of h(piece, B), computed: without slack
  std::uint32_t triangle = 0;   // of A
  std::uint32_t depth = 0;      // subdivisions since the whole triangle
  bool overlay_failed = false;  // the overlay bound cannot succeed, or is not worth trying again
};

// What distinguishes the paper's strategies. One object a search; not thread safe.
class PieceBound {
 public:
  PieceBound() = default;
  PieceBound(const PieceBound&) = delete;
  PieceBound& operator=(const PieceBound&) = delete;
  virtual ~PieceBound() = default;

  // d(p, B) for p, a new corner of a part of `parent`.
  virtual Corner measure(const Vec3& p, const Piece& parent) = 0;

  // An upper bound of h(piece, B), computed from the piece's corners: rounding.h R3 and R4 give its slack.
  virtual double upper(const Piece& piece) = 0;

  // What the strategy itself keeps in memory; counts towards Options::max_memory_bytes.
  virtual std::size_t memory_bytes() const { return 0; }
};

// A query for a point's nearest triangle, counted. `hint`: see nearest().
inline Corner nearest_corner(const Bvh& target, const Vec3& p, Work& work, std::uint32_t hint = Nearest::kNone) {
  ++work.nearest_queries;
  const Nearest found = nearest(target, p, work.triangle_tests, hint);
  return {p, found.distance, found.slot};
}

// eq. 9: max over the piece's corners v of d(v, T), for triangles T of B. d(., T) is convex, so its maximum over the
// piece is at a corner: this bounds h(piece, T) and so h(piece, B).
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

  double operator()(std::uint32_t slot, Work& work) const {
    work.triangle_tests += 3;
    return target_.farthest(corners_, slot);
  }

 private:
  const Bvh& target_;
  PointBlock corners_;
};

// eq. 8: min over the candidates T of max over corners v of d(v, T). The minimum over any set of triangles of B bounds
// h(piece, B), because each one does.
inline double least_farthest(const Piece& piece, const Bvh& target, std::span<const std::uint32_t> candidates,
                             Work& work) {
  const Certificate certificate(piece.corners, target);
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t slot : candidates) least = std::min(least, certificate(slot, work));
  return least;
}

}  // namespace meshgauge
