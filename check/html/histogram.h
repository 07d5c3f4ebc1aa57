// How a surface is distributed over distances.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "check/html/axis.h"
#include "engine/mesh.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

// Estimates from points spread evenly over the surface: nothing here is certified.
struct Histogram {
  Axis axis;  // of the distances
  std::vector<double>
      shares;              // of the area, by bin of equal width on the axis; below its beginning counts to the first
  std::size_t points = 0;  // 0: the surface has no area
  double above_limit = 0;  // share of the area
  double median = 0;
  double p95 = 0;
  double largest = 0;
};

// Distances at `points` places, each of which stands for the same area: along the mesh in steps of equal area, and
// within the triangles by a sequence of low discrepancy. Deterministic. `distance` must be thread safe.
Histogram histogram_of(MeshView mesh, const std::function<double(const Vec3&)>& distance, double limit,
                       std::size_t points, ThreadPool& pool);

// Points of equal shares of the area; none where there is no area.
std::vector<Vec3> spread_points(MeshView mesh, std::size_t count);

}  // namespace meshgauge::check
