// What a measurement is asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "engine/statistics.h"

namespace meshgauge {

enum class Direction { symmetric, a_to_b, b_to_a };

// How a piece of the mesh is bounded from above; engine/bounds/ has one file each.
enum class Strategy {
  automatic,     // the default and the fastest: certificates, overlay and Lipschitz bounds, bisection
  four_point,    // the paper's: candidates are the owners of the points nearest to 3 corners and centroid
  n_point,       // the same with Options::points samples a piece
  triangle_set,  // Tang, Lee, Kim 2009: all triangles that can matter, found once for a triangle
};

// Stop rules (paper section 5.1); the first that holds ends the work. All in the meshes' unit.
struct Tolerance {
  std::optional<double> absolute;  // U - L <= absolute                 (eq. 14)
  std::optional<double> diagonal;  // U - L <= diagonal * Diag(A)       (eq. 15); Diag is always mesh a's
  std::optional<double> relative;  // U - L <= relative * L             (eq. 17)
};

struct Options {
  Direction direction = Direction::symmetric;
  Tolerance tolerance{std::nullopt, 1e-6, 0.01};
  std::optional<double> max_distance;  // the gate: stop as soon as U <= max_distance or L > max_distance
  Strategy strategy = Strategy::automatic;
  int points = 4;                                         // n_point only: 4, 10, 31, 109, 409 or 1585
  std::size_t max_memory_bytes = std::size_t{512} << 20;  // of the waiting pieces; when spent: Stop::budget
  std::uint64_t max_work_items = std::numeric_limits<std::uint64_t>::max();  // pieces split; when spent: Stop::budget
  unsigned threads = 1;                // of this job, at least 1; more than one for `automatic` only
  std::string_view simd = "auto";      // the instruction set: one of supported_simd(), or "auto" for the fastest
  std::optional<Sampling> statistics;  // sampled after the measurement, if there is time left
};

// The instruction sets of this processor, the fastest first; the last one is "scalar". They give the same bits.
std::span<const std::string_view> supported_simd();

// Whether `points` is one of the stencils of n_point.
bool is_stencil(int points);

}  // namespace meshgauge
