// The paper's n-point bound (Figure 1): the candidates are the owners of n regularly spread samples of the piece.
//
// The samples are the corners and the centroids of the piece cut uniformly k times: with m = 2^k cuts an edge,
// (m+1)(m+2)/2 + m^2 of them, that is 4, 10, 31, 109, 409 and 1585 for k = 0..5. Four points is strategy `four_point`.
// Statement and proof: as in four_point.h, which holds for any set of candidates.
#pragma once

#include <optional>
#include <vector>

#include "engine/bounds/piece.h"

namespace meshgauge {

// k for n samples; none if there is no such stencil.
std::optional<int> stencil_level(int points);

class NPoint final : public PieceBound {
 public:
  // Once `interrupted`, bounds are made of fewer samples: looser, but valid.
  NPoint(const Bvh& target, int level, Work& work, Interrupted interrupted = never_interrupted);

  Corner measure(const Vec3& p, const Piece& parent) override;
  double upper(const Piece& piece) override;

 private:
  const Bvh& target_;
  std::vector<Vec3> weights_;  // barycentric, of the samples other than the corners
  Work& work_;
  Interrupted interrupted_;
  std::vector<std::uint32_t> owners_;  // of the piece at hand
};

}  // namespace meshgauge
