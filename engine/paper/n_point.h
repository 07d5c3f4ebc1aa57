// The paper's n-point bound (Figure 1): the candidates are the owners of n regular samples of the piece. The owner of a
// point is the triangle of B that holds the point of B nearest to it.
//
// The samples are the corners and the centroids of the piece cut uniformly k times: with m = 2^k parts of an edge they
// are (m+1)(m+2)/2 + m^2, that is 4, 10, 31, 109, 409 and 1585 for k = 0..5. Four points are the strategy `four_point`.
// Statement and proof: as in four_point.h, which hold for any set of candidates.
#pragma once

#include <optional>
#include <vector>

#include "engine/search/piece.h"

namespace meshgauge {

// Returns k for n = `points` samples. nullopt: no k gives this number.
std::optional<int> stencil_level(int points);

class NPoint final : public PieceBound {
 public:
  // `level`: k. `stop`: see nearest(). When it returns true, bounds use fewer samples: they are looser, but hold.
  NPoint(const Bvh& target, int level, Work& work, const Interrupted* stop = nullptr);

  Corner measure(const Vec3& p, const Piece& parent) override;
  double upper(const Piece& piece) override;

 private:
  const Bvh& target_;
  std::vector<Vec3> weights_;  // barycentric coordinates of the samples other than the corners
  Work& work_;
  const Interrupted* stop_;
  Polling polling_;
  std::vector<std::uint32_t> owners_;  // of the current piece
};

}  // namespace meshgauge
