// Makes deviation maps: measures distances, refines or decimates the mesh for display, sets the colour scale. `check
// --deviation` and the service share it, so that both write the same map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "api/map/deviation_map.h"
#include "api/result/result_document.h"
#include "engine/control.h"
#include "engine/result.h"
#include "engine/tree/prepared.h"

namespace meshgauge::api {

struct MapOptions {
  // Splits edges longer than 1/64 of the candidate's diagonal, to at most kMostRefined triangles: viewers that show
  // vertex colours alone show nothing between vertices.
  bool refine = false;
  // A candidate with more is decimated; of a cloud with more points, evenly many are left.
  std::size_t max_triangles = std::numeric_limits<std::size_t>::max();
  // Also the normal of each vertex: the sum of those of its triangles, weighted by area, from the candidate's corners
  // counterclockwise; z where that is 0. A cloud has none.
  bool normals = false;
  unsigned threads = 1;
  std::string_view simd = "auto";

  static constexpr std::size_t kMostRefined = 250'000;
};

// A map and the arrays it borrows, except the candidate's own. Must not outlive the candidate.
class MadeMap {
 public:
  const DeviationMap& map() const { return map_; }

 private:
  friend Result<MadeMap> make_deviation(const Prepared&, const Prepared&, const ResultFacts&, const MapOptions&,
                                        Control&);
  Mesh shown_;
  std::vector<double> distances_;
  std::vector<std::int8_t> sides_;
  std::vector<Vec3> normals_;
  DeviationMap map_;

 public:
  MadeMap() = default;
  MadeMap(MadeMap&&) = default;
  MadeMap& operator=(MadeMap&&) = default;
  MadeMap(const MadeMap&) = delete;
  MadeMap& operator=(const MadeMap&) = delete;
};

// Makes a map of the distance from `candidate` to `baseline`. Precondition: both are in the unit of the comparison's
// result (in_unit(), api/compare/prepared_mesh.h). No distance exceeds the certified upper bound of that direction. A
// decimated map is measured at every vertex of the candidate and prefers to keep vertices above the limit; the farthest
// vertex is always kept. With facts.sides each vertex that is shown has its side, unless the baseline has none: the map
// says why. Error: out_of_time when `control` says to stop.
Result<MadeMap> make_deviation(const Prepared& candidate, const Prepared& baseline, const ResultFacts& facts,
                               const MapOptions& options, Control& control);

}  // namespace meshgauge::api
