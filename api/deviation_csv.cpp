#include "api/deviation_csv.h"

#include "api/decimal.h"

namespace meshgauge::api {

void write_deviation_csv(const DeviationMap& map, std::ostream& out) {
  out << "x,y,z,distance" << (map.sides.empty() ? "" : ",signed_distance")
      << (map.normals.empty() ? "\n" : ",nx,ny,nz\n");
  for (std::size_t v = 0; v < map.mesh.positions.size(); ++v) {
    for (const double x : map.mesh.positions[v]) out << shortest(x) << ',';
    out << shortest(map.distances[v]);
    if (!map.sides.empty()) out << ',' << shortest(map.signed_distance(v));
    if (!map.normals.empty()) {
      for (const double x : map.normals[v]) out << ',' << shortest(x);
    }
    out << '\n';
  }
}

}  // namespace meshgauge::api
