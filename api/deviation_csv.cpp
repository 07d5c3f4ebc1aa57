#include "api/deviation_csv.h"

#include <string>

#include "api/decimal.h"

namespace meshgauge::api {
namespace {

std::string quoted(const std::string& text) {
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

}  // namespace

void write_deviation_csv(const DeviationMap& map, std::ostream& out) {
  out << "x,y,z,distance" << (map.sides.empty() ? "" : ",signed_distance") << (map.normals.empty() ? "" : ",nx,ny,nz")
      << (map.no_sides.empty() ? "\n" : ",no_sides\n");
  for (std::size_t v = 0; v < map.mesh.positions.size(); ++v) {
    for (const double x : map.mesh.positions[v]) out << shortest(x) << ',';
    out << shortest(map.distances[v]);
    if (!map.sides.empty()) out << ',' << shortest(map.signed_distance(v));
    if (!map.normals.empty()) {
      for (const double x : map.normals[v]) out << ',' << shortest(x);
    }
    if (!map.no_sides.empty()) out << ',' << (v == 0 ? quoted(map.no_sides) : "");
    out << '\n';
  }
}

}  // namespace meshgauge::api
