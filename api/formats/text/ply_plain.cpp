#include "api/formats/text/ply_plain.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>

#include "api/formats/file/source.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "little-endian PLY is read as the machine's own numbers");

template <class T>
T load(const char* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

template <class T>
bool read_all(const char* record, const PlainVertices& records, std::size_t count, Vec3* to) {
  Vec3 nothing = Vec3::Zero();  // stays zero, unless a coordinate is NaN or infinite
  for (std::size_t i = 0; i < count; ++i, record += records.record_bytes) {
    const Vec3 p(static_cast<double>(load<T>(record + records.at[0])),
                 static_cast<double>(load<T>(record + records.at[1])),
                 static_cast<double>(load<T>(record + records.at[2])));
    nothing += p * 0.0;
    to[i] = p;
  }
  return nothing.isZero(0);
}

template <class Length>
std::size_t read_some(const char* record, const PlainFaces& records, std::size_t most, std::uint64_t vertices,
                      std::vector<Triangle>& to) {
  TriangleBlock block(to);
  std::size_t read = 0;
  for (; read < most; ++read, record += records.triangle_bytes) {
    const char* const length = record + records.length_at;
    const auto corners = load<Triangle>(length + sizeof(Length));
    if (load<Length>(length) != 3 || std::max({corners[0], corners[1], corners[2]}) >= vertices) break;
    block.add(corners);
  }
  block.flush();
  return read;
}

}  // namespace

std::optional<PlainVertices> plain_vertices(const PlyElement& element) {
  PlainVertices records;
  std::size_t doubles = 0, floats = 0;
  for (const PlyProperty& property : element.properties) {
    if (property.is_list) return std::nullopt;
    const std::size_t axis = property.name.size() == 1 ? std::string_view("xyz").find(property.name) : 3;
    if (axis < 3) {
      records.at[axis] = records.record_bytes;
      doubles += property.type == PlyType::float64;
      floats += property.type == PlyType::float32;
    }
    records.record_bytes += size_of(property.type);
  }
  records.is_double = doubles == 3;
  return doubles == 3 || floats == 3 ? std::optional(records) : std::nullopt;
}

bool read_vertices(const char* bytes, const PlainVertices& records, std::size_t count, Vec3* to) {
  return records.is_double ? read_all<double>(bytes, records, count, to) : read_all<float>(bytes, records, count, to);
}

std::optional<PlainFaces> plain_faces(const PlyElement& element, const PlyProperty* corners) {
  PlainFaces records;
  for (const PlyProperty& property : element.properties) {
    records.last_bytes = size_of(property.type);
    if (&property == corners) {
      records.length_at = records.triangle_bytes;
      records.length_bytes = size_of(property.count_type);
      records.triangle_bytes += records.length_bytes + 2 * size_of(property.type);
    } else if (property.is_list) {
      return std::nullopt;
    }
    records.triangle_bytes += size_of(property.type);
  }
  const bool has_lengths = records.length_bytes == 1 || records.length_bytes == 4;
  if (!has_lengths || size_of(corners->type) != 4) return std::nullopt;
  records.most_vertices = std::uint64_t{1} << (corners->type == PlyType::int32 ? 31U : 32U);
  return records;
}

std::size_t read_triangles(const char* bytes, const PlainFaces& records, std::size_t most, std::uint64_t vertices,
                           std::vector<Triangle>& to) {
  vertices = std::min(vertices, records.most_vertices);
  return records.length_bytes == 1 ? read_some<std::uint8_t>(bytes, records, most, vertices, to)
                                   : read_some<std::uint32_t>(bytes, records, most, vertices, to);
}

}  // namespace meshgauge::api
