// The distance of each vertex of one mesh from another mesh, for pictures of the deviation.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/control.h"
#include "engine/tree/prepared.h"

namespace meshgauge {

// A vertex that no triangle uses is not part of the surface: its distance is 0 and its nearest triangle kNone.
struct Deviation {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // By vertex of the mesh measured from, in the meshes' unit. Computed, not certified: off by at most a few hundred
  // units of rounding (2^-53) of the size of both meshes together, but never above DeviationOptions::upper. Exactly 0
  // if the vertex is a corner of its nearest triangle or belongs to a triangle that both meshes have.
  std::vector<double> distances;
  // By vertex: a triangle of the other mesh that holds the nearest point.
  std::vector<std::uint32_t> nearest;
  // By vertex: 1 where it is proved to be outside of the other mesh, -1 inside (engine/sides.h), 0 where neither is, as
  // on its surface. Empty: not asked for, or the other mesh has no sides.
  std::vector<std::int8_t> sides;
  std::uint32_t farthest = 0;  // the first vertex with the largest distance
};

struct DeviationOptions {
  unsigned threads = 1;            // at least 1
  std::string_view simd = "auto";  // as Options::simd
  // A certified bound of every distance from the one mesh to the other; larger distances, which rounding can cause, are
  // reduced to it.
  double upper = std::numeric_limits<double>::infinity();
  bool sides = false;  // fill Deviation::sides
};

// Measures every vertex of `from`. The largest distance is a lower bound of h(from, to), up to rounding; between
// vertices the surface may be farther away (engine/extras/display/refinement.h). The distances do not depend on the
// number of threads. Uses the structures that measure() has built for the same two meshes and builds missing ones.
// nullopt: interrupted by `control`, polled every 10 ms. Precondition: both meshes pass validate().
std::optional<Deviation> deviation(const Prepared& from, const Prepared& to, const DeviationOptions& options,
                                   Control& control);

}  // namespace meshgauge
