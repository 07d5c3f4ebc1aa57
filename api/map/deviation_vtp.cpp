#include "api/map/deviation_vtp.h"

#include <bit>
#include <cmath>
#include <string>

#include "api/base/figures.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "written as it is in memory");

template <class T>
void put(std::ostream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

// Writes the XML first, then the arrays that it announced: each its size in bytes and its elements.
class Writer {
 public:
  Writer(const DeviationMap& map, std::ostream& out) : map_(map), out_(out) {}

  void write() {
    head();
    out_ << "<AppendedData encoding=\"raw\">_";
    const std::size_t points = map_.mesh.positions.size();
    array(points, [&](std::size_t v) { return map_.distances[v]; });
    if (!map_.sides.empty()) array(points, [&](std::size_t v) { return map_.signed_distance(v); });
    for (const auto& vectors : {map_.normals, map_.mesh.positions})
      if (!vectors.empty()) array(3 * points, [&](std::size_t i) { return vectors[i / 3][static_cast<int>(i % 3)]; });
    const auto corners = static_cast<std::size_t>(corners_of_cell());
    array(corners * cells(), [&](std::size_t i) { return corner(i); });
    array(cells(), [&](std::size_t i) { return static_cast<std::int64_t>((i + 1) * corners); });
    out_ << "</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::size_t cells() const { return map_.is_cloud() ? map_.mesh.positions.size() : map_.mesh.triangles.size(); }
  int corners_of_cell() const { return map_.is_cloud() ? 1 : 3; }
  std::int64_t corner(std::size_t i) const {
    return map_.is_cloud() ? static_cast<std::int64_t>(i) : std::int64_t{map_.mesh.triangles[i / 3][i % 3]};
  }

  void head() {
    out_ << "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n";
    fact(map_.scale.limited ? "limit" : "largest", map_.scale.top);
    if (!map_.limit_side.empty()) fact("limit_side", map_.limit_side == "outside" ? 1 : -1);
    fact("lower", map_.lower);
    if (std::isfinite(map_.upper)) fact("upper", map_.upper);
    if (!map_.no_sides.empty()) fact("no_sides", map_.no_sides);
    const std::string cloud = std::to_string(map_.is_cloud() ? cells() : 0);
    const std::string faces = std::to_string(map_.is_cloud() ? 0 : cells());
    out_ << "</FieldData>\n<Piece NumberOfPoints=\"" << map_.mesh.positions.size() << "\" NumberOfVerts=\"" << cloud
         << "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" << faces << "\">\n";
    const std::size_t points = map_.mesh.positions.size();
    out_ << "<PointData Scalars=\"distance\"" << (map_.normals.empty() ? "" : " Normals=\"Normals\"") << ">\n";
    announce("Float64", "distance", 1, points);
    if (!map_.sides.empty()) announce("Float64", "signed_distance", 1, points);
    if (!map_.normals.empty()) announce("Float64", "Normals", 3, 3 * points);
    out_ << "</PointData>\n<Points>\n";
    announce("Float64", "Points", 3, 3 * points);
    const char* kind = map_.is_cloud() ? "Verts" : "Polys";
    out_ << "</Points>\n<" << kind << ">\n";
    announce("Int64", "connectivity", 1, static_cast<std::size_t>(corners_of_cell()) * cells());
    announce("Int64", "offsets", 1, cells());
    out_ << "</" << kind << ">\n</Piece>\n</PolyData>\n";
  }

  void fact(const char* name, double value) {
    out_ << "<DataArray type=\"Float64\" Name=\"" << name << "\" NumberOfTuples=\"1\" format=\"ascii\">"
         << shortest(value) << "</DataArray>\n";
  }

  // A text is the numbers of its bytes and a 0, so that none needs an escape.
  void fact(const char* name, const std::string& text) {
    out_ << "<DataArray type=\"String\" Name=\"" << name << "\" NumberOfTuples=\"1\" format=\"ascii\">";
    for (const char c : text) out_ << int{static_cast<unsigned char>(c)} << ' ';
    out_ << "0</DataArray>\n";
  }

  // Every element has 8 bytes.
  void announce(const char* type, const char* name, int components, std::size_t elements) {
    out_ << "<DataArray type=\"" << type << "\" Name=\"" << name << "\" NumberOfComponents=\"" << components
         << "\" format=\"appended\" offset=\"" << offset_ << "\"/>\n";
    offset_ += sizeof(std::uint64_t) + 8 * elements;
  }

  template <class Element>
  void array(std::size_t elements, const Element& element) {
    put(out_, std::uint64_t{8 * elements});
    for (std::size_t i = 0; i < elements; ++i) put(out_, element(i));
  }

  const DeviationMap& map_;
  std::ostream& out_;
  std::size_t offset_ = 0;
};

}  // namespace

void write_deviation_vtp(const DeviationMap& map, std::ostream& out) { Writer(map, out).write(); }

}  // namespace meshgauge::api
