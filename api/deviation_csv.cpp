#include "api/deviation_csv.h"

#include "api/decimal.h"

namespace meshgauge::api {

void write_deviation_csv(const DeviationMap& map, std::ostream& out) {
  out << "x,y,z,distance\n";
  for (std::size_t v = 0; v < map.mesh.positions.size(); ++v) {
    for (const double x : map.mesh.positions[v]) out << shortest(x) << ',';
    out << shortest(map.distances[v]) << '\n';
  }
}

}  // namespace meshgauge::api
