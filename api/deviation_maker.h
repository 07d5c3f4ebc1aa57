// The way to a deviation map: measure, choose what to show, know what the numbers mean. For `check --deviation` and for
// the service, so that both write the same.
#pragma once

#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "api/deviation_map.h"
#include "api/result_document.h"
#include "engine/control.h"
#include "engine/prepared.h"
#include "engine/result.h"

namespace meshgauge::api {

struct MapOptions {
  // Readers that show colours alone see nothing of what lies between vertices: edges longer than a 64th of the
  // candidate's diagonal are split, to at most kMostRefined triangles.
  bool refine = false;
  std::size_t max_triangles = std::numeric_limits<std::size_t>::max();  // a candidate of more is decimated
  unsigned threads = 1;
  std::string_view simd = "auto";

  static constexpr std::size_t kMostRefined = 250'000;
};

// A map with what it borrows, but for the candidate's own arrays.
class MadeMap {
 public:
  const DeviationMap& map() const { return map_; }

 private:
  friend Result<MadeMap> make_deviation(const Prepared&, const Prepared&, const ResultFacts&, const MapOptions&,
                                        Control&);
  Mesh shown_;
  std::vector<double> distances_;
  DeviationMap map_;

 public:
  MadeMap() = default;
  MadeMap(MadeMap&&) = default;
  MadeMap& operator=(MadeMap&&) = default;
  MadeMap(const MadeMap&) = delete;
  MadeMap& operator=(const MadeMap&) = delete;
};

// Both meshes are in the unit of the comparison's result (in_unit(), api/prepared_mesh.h).
// Distances are never above what is certified of the candidate's. Of a decimated map they are measured at every vertex
// of the candidate, and what is farthest away or above the limit is shown rather than its neighbours: the farthest
// vertex always, also of a part that is otherwise too small to be shown.
// out_of_time when `control` said to stop. The map must not outlive the candidate.
Result<MadeMap> make_deviation(const Prepared& candidate, const Prepared& baseline, const ResultFacts& facts,
                               const MapOptions& options, Control& control);

}  // namespace meshgauge::api
