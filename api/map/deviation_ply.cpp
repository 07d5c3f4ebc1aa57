#include "api/map/deviation_ply.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>

#include "api/base/figures.h"
#include "api/base/utf8.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "written as it is in memory");

std::string coordinates(const Vec3& p) { return shortest(p.x()) + " " + shortest(p.y()) + " " + shortest(p.z()); }

// Replaces characters that would end a line of the header.
std::string one_line(std::string text) {
  std::replace_if(text.begin(), text.end(), is_control, ' ');
  return text;
}

bool is_float(const Vec3& p) { return p.cast<float>().cast<double>() == p; }

class Header {
 public:
  void line(std::string_view text) { text_.append(text) += '\n'; }
  void comment(const std::string& text) { line("comment " + text); }
  const std::string& end() { return line("end_header"), text_; }

 private:
  std::string text_;
};

void describe(const DeviationMap& map, Header& header) {
  header.comment("meshgauge deviation map: distance of each vertex from the baseline, computed, not certified");
  if (!map.units.empty()) header.comment("unit " + one_line(map.units));
  header.comment((map.scale.limited ? "limit " : "largest ") + shortest(map.scale.top) +
                 (map.limit_side.empty() ? "" : " " + map.limit_side));
  header.comment("certified interval of the measurement " + shortest(map.lower) + " " + shortest(map.upper));
  if (!map.sides.empty())
    header.comment("signed_distance is positive outside of the baseline, negative inside, nan where neither is proved");
  if (!map.no_sides.empty()) header.comment("no signed_distance: " + one_line(map.no_sides));
  if (map.witness) {
    const ResultWitness& w = *map.witness;
    header.comment("witness from " + coordinates(w.from) + " triangle " + std::to_string(w.from_triangle) + " of the " +
                   w.from_mesh());
    header.comment("witness to " + coordinates(w.to) + " triangle " + std::to_string(w.to_triangle) + " of the " +
                   w.to_mesh());
  }
  if (map.form == MapForm::refined) {
    header.comment("refined for display: the first " + std::to_string(map.candidate_vertices) +
                   " vertices are the candidate's");
  }
}

void write_header(const DeviationMap& map, const std::string& coordinate, std::ostream& out) {
  Header header;
  header.line("ply");
  header.line("format binary_little_endian 1.0");
  describe(map, header);
  header.line("element vertex " + std::to_string(map.mesh.positions.size()));
  for (const char* name : {" x", " y", " z"}) header.line("property " + coordinate + name);
  for (const char* name : {" nx", " ny", " nz"}) {
    if (!map.normals.empty()) header.line(std::string("property float") + name);
  }
  for (const char* name : {"red", "green", "blue"}) header.line(std::string("property uchar ") + name);
  header.line("property float quality");
  header.line("property double distance");
  if (!map.sides.empty()) header.line("property double signed_distance");
  if (!map.is_cloud()) {
    header.line("element face " + std::to_string(map.mesh.triangles.size()));
    header.line("property list uchar uint vertex_indices");
  }
  out << header.end();
}

// A buffer for one element of at most 24 + 12 + 3 + 4 + 8 + 8 bytes.
class Record {
 public:
  template <class T>
  void put(const T& value) {
    std::memcpy(bytes_ + size_, &value, sizeof value);
    size_ += sizeof value;
  }
  void write(std::ostream& out) const { out.write(bytes_, static_cast<std::streamsize>(size_)); }

 private:
  char bytes_[64];
  std::size_t size_ = 0;
};

template <class Coordinate>
void write_vertices(const DeviationMap& map, std::ostream& out) {
  for (std::size_t v = 0; v < map.mesh.positions.size(); ++v) {
    const double distance = map.distances[v];
    Record record;
    for (const double x : map.mesh.positions[v]) record.put(static_cast<Coordinate>(x));
    if (!map.normals.empty()) {
      for (const double x : map.normals[v]) record.put(static_cast<float>(x));
    }
    record.put(colour_of(distance, map.scale));
    record.put(static_cast<float>(distance));
    record.put(distance);
    if (!map.sides.empty()) record.put(map.signed_distance(v));
    record.write(out);
  }
}

void write_faces(const DeviationMap& map, std::ostream& out) {
  for (const Triangle& triangle : map.mesh.triangles) {
    Record record;
    record.put(std::uint8_t{3});
    record.put(triangle);
    record.write(out);
  }
}

}  // namespace

void write_deviation_ply(const DeviationMap& map, std::ostream& out) {
  const bool single = std::all_of(map.mesh.positions.begin(), map.mesh.positions.end(), is_float);
  write_header(map, single ? "float" : "double", out);
  if (single) {
    write_vertices<float>(map, out);
  } else {
    write_vertices<double>(map, out);
  }
  if (!map.is_cloud()) write_faces(map, out);
}

}  // namespace meshgauge::api
