// Certified distribution of the distance over a surface: how much of the area is farther from the other mesh than a
// given distance, quantiles, mean and RMS. Each is an interval that holds the exact value (docs/design.md, section 10);
// engine/statistics.h has the estimates from samples.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace meshgauge {

// What is asked of each direction of a measurement. Lengths in the meshes' unit, shares from 0 to 1.
struct AreaOptions {
  static constexpr double kLeastLength = 0.01;
  static constexpr double kGateTolerance = 1e-6;    // share_tolerance of a gate, where that is less
  static constexpr std::size_t kMaxBeyond = 16;     // distances
  static constexpr std::size_t kMaxQuantiles = 16;  // quantiles

  // The share of the area that is farther than `distance` >= 0 from the other mesh.
  struct Beyond {
    double distance = 0;
    // A gate: the share is narrowed until it is at most this, or above it; Options::narrow narrows it further.
    std::optional<double> max_share;
  };
  std::vector<Beyond> beyond;
  // For each p, 0 < p < 1: the smallest distance that the share p of the area is within.
  std::vector<double> quantiles;
  bool mean = false;               // the mean and the root of the mean square
  double share_tolerance = 0.001;  // the width of a share's interval
  // The width of a length's interval, relative to its upper end, or to kLeastLength of the direction's upper bound
  // where that is more: a quantile may be 0.
  double length_tolerance = 0.01;
};

// Whether anything is asked.
inline bool asks_something(const AreaOptions& asked) {
  return !asked.beyond.empty() || !asked.quantiles.empty() || asked.mean;
}

struct AreaInterval {
  double lower = 0;
  double upper = 0;
};

// Why narrowing ended. The intervals hold in every case.
enum class AreaStop {
  complete,         // every interval is as narrow as asked for, or its gate is decided
  precision_floor,  // rounding allows no narrower interval: distances equal a limit, or are 0
  timeout,
  cancelled,
  budget,   // Options::max_memory_bytes or max_work_items was reached, or no memory was left
  no_area,  // all triangles are degenerate: nothing is known of a share of their area
};

// The distribution of the distance from the points of one mesh to the other mesh, by area.
struct AreaBounds {
  std::vector<AreaInterval> beyond;     // shares, in the order of AreaOptions::beyond
  std::vector<AreaInterval> quantiles;  // distances, in the order of AreaOptions::quantiles
  std::optional<AreaInterval> mean;     // nullopt: not asked for
  std::optional<AreaInterval> rms;
  std::uint64_t pieces = 0;  // triangles and parts of triangles that were bounded
  AreaStop stop = AreaStop::complete;
};

struct AreaOutcome {
  AreaOptions options;
  std::optional<AreaBounds> a_to_b;  // nullopt: not asked for
  std::optional<AreaBounds> b_to_a;
};

}  // namespace meshgauge
