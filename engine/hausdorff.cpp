#include "engine/hausdorff.h"

#include <algorithm>
#include <vector>

#include "engine/kernels/kernels.h"
#include "engine/measure/measurement.h"
#include "engine/paper/n_point.h"
#include "engine/tree/prepared.h"

namespace meshgauge {

Work& Work::operator+=(const Work& other) {
  nearest_queries += other.nearest_queries;
  cache_hits += other.cache_hits;
  triangle_tests += other.triangle_tests;
  subdivisions += other.subdivisions;
  max_depth = std::max(max_depth, other.max_depth);
  peak_heap = std::max(peak_heap, other.peak_heap);
  return *this;
}

bool is_stencil(int points) { return stencil_level(points).has_value(); }

std::span<const std::string_view> supported_simd() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> result;
    for (const Kernels& kernels : supported_kernels()) result.emplace_back(kernels.name);
    return result;
  }();
  return names;
}

const char* version() { return MESHGAUGE_VERSION; }

Outcome measure(const Prepared& a, const Prepared& b, const Options& options, Control& control) {
  return Measurement(a, b, options, control).run();
}

Outcome measure(MeshView a, MeshView b, const Options& options, Control& control) {
  return measure(Prepared(a), Prepared(b), options, control);
}

}  // namespace meshgauge
