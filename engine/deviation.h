// How far each vertex of one mesh is from another: what a picture of the deviation is drawn from.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/control.h"
#include "engine/prepared.h"

namespace meshgauge {

struct Deviation {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // By vertex of the mesh measured from; in the meshes' unit. Computed, not certified: off by at most a few hundred
  // units of rounding, 2^-53, of the size of both meshes together; but never above DeviationOptions::upper. Exactly 0
  // where the vertex is a corner of its nearest triangle or belongs to a triangle that both meshes have; so of equal
  // meshes all are 0.
  std::vector<double> distances;
  // By vertex: the triangle of the other mesh that holds the nearest point, one of them if there are many.
  std::vector<std::uint32_t> nearest;
  std::uint32_t farthest = 0;  // the vertex that is farthest away, the first of them

  // A vertex that no triangle uses is not part of the surface: 0 and kNone.
};

struct DeviationOptions {
  unsigned threads = 1;            // at least 1
  std::string_view simd = "auto";  // as Options::simd
  // Certified to bound every distance from the one mesh to the other: what rounding puts above it is taken off.
  double upper = std::numeric_limits<double>::infinity();
};

// Both pass validate(). The maximum is a lower bound of h(from, to), but for rounding; between vertices the surface may
// be farther away (engine/refinement.h). Uses what measure() of the same two has made, and makes what there is not yet.
// The distances are the same on however many threads. nullopt: `control` said to stop, which it is asked every 10 ms.
std::optional<Deviation> deviation(const Prepared& from, const Prepared& to, const DeviationOptions& options,
                                   Control& control);

}  // namespace meshgauge
