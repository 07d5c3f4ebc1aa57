#include "api/map/deviation_map.h"

#include "api/base/figures.h"
#include "api/map/deviation_glb.h"
#include "api/map/deviation_ply.h"
#include "api/map/deviation_vtp.h"

namespace meshgauge::api {
namespace {

std::string quoted(const std::string& text) {
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

// Writes CSV (RFC 4180, but lines end in LF): x,y,z,distance and, with sides, signed_distance, nan where it is not
// proved, and, with normals, nx,ny,nz; a line for each vertex, in the order of the mesh. Where signs were asked for and
// there are none, the last column is no_sides: the reason on the first line, nothing on the others. Numbers are the
// shortest texts that read back as the same double.
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

}  // namespace

Result<Done> write_deviation(const DeviationMap& map, MapKind kind, std::ostream& out) {
  switch (kind) {
    case MapKind::ply:
      return write_deviation_ply(map, out), Done{};
    case MapKind::glb:
      return write_deviation_glb(map, out);
    case MapKind::vtp:
      return write_deviation_vtp(map, out), Done{};
    default:
      return write_deviation_csv(map, out), Done{};
  }
}

}  // namespace meshgauge::api
