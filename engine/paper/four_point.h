// The paper's bound (section 4): at most four candidate triangles for a piece.
// Points that a subdivision makes are shared, too: each is queried once for the two parts beside its edge.
//
// Statement. Let L be the triangles of B that own the points nearest to the piece's three corners and to its
// centroid. Then h(piece, B) <= min over T in L of max over corners v of d(v, T)   (eq. 8-10).
// Proof. For any T of B, d(., B) <= d(., T) on the piece, and d(., T) is convex because T is, so its maximum over the
// piece is attained at a corner. The minimum over any set of T keeps the inequality. Computed by least_farthest().
#pragma once

#include <unordered_map>

#include "engine/mesh/index_table.h"
#include "engine/search/piece.h"

namespace meshgauge {

class FourPoint final : public PieceBound {
 public:
  // `stop`: see nearest(). When it returns true, bounds are looser, but hold.
  FourPoint(const Bvh& target, Work& work, const Interrupted* stop = nullptr)
      : target_(target), work_(work), stop_(stop) {}

  Corner measure(const Vec3& p, const Piece& parent) override;
  double upper(const Piece& piece) override;
  std::size_t memory_bytes() const override { return shared_.size() * kBytesOfShared; }

 private:
  struct Hash {
    std::size_t operator()(const Vec3& p) const { return hash_of(p); }
  };
  struct Found {
    double distance;
    std::uint32_t slot;
  };
  using Shared = std::unordered_map<Vec3, Found, Hash>;
  static constexpr std::size_t kBytesOfShared = sizeof(Shared::value_type) + 4 * sizeof(void*);  // with the table

  const Bvh& target_;
  Work& work_;
  const Interrupted* stop_;
  Shared shared_;  // points of subdivisions that were queried once; an edge has two sides, so the second takes it out
};

}  // namespace meshgauge
