// Distribution of distances over a surface, and axes of diagrams: positions of numbers, and their ticks.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

// Linear, or logarithmic for numbers of several magnitudes. low < high, both finite; low > 0 on a logarithmic axis,
// where smaller numbers lie at its beginning.
struct Axis {
  bool logarithmic = false;
  double low = 0;
  double high = 1;

  double at(double x) const;         // from 0 at the beginning to 1 at the end, clamped; NaN is 0
  double value(double share) const;  // inverse of at()
};

// Returns an axis that shows all of `values` with room on both sides. Ignores values that are not positive and
// finite. Values close together get an axis around them, values of several magnitudes a logarithmic one.
Axis axis_for(std::span<const double> values);

struct AxisTick {
  double value = 0;
  std::string label;
};

// Returns round numbers on the axis, at most nine.
std::vector<AxisTick> ticks(const Axis& axis);

// Estimated from points spread evenly over the surface; not certified.
struct Histogram {
  Axis axis;  // axis of distances
  std::vector<double>
      shares;  // share of the area for each bin of equal width on the axis; the first bin includes smaller distances
  std::size_t points = 0;  // 0: the surface has no area
  double above_limit = 0;  // share of the area
  double median = 0;
  double p95 = 0;
  double largest = 0;
  bool of_cloud = false;    // shares are of its points
  bool all_points = false;  // each of them was measured
};

// Samples `distance` at `points` points of equal area: along the mesh in steps of equal area, and within triangles by
// a low-discrepancy sequence; of a cloud its own points, each or every so many. Deterministic. `distance` must be
// thread safe.
Histogram histogram_of(MeshView mesh, const std::function<double(const Vec3&)>& distance, double limit,
                       std::size_t points, ThreadPool& pool);

// Points that each stand for an equal share of the area, or of a cloud's points; empty if the mesh has no area.
std::vector<Vec3> spread_points(MeshView mesh, std::size_t count);

}  // namespace meshgauge::check
