#include "api/formats/stl_binary.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "api/formats/room.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as the machine's own floats");

constexpr std::size_t kCountAt = 80;
constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kFacetBytes = 50;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kAttributeAt = 48;  // in a facet: the count of its attribute bytes

std::size_t facet_count(std::span<const std::byte> bytes, std::endian order) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t shift = 8 * (order == std::endian::little ? i : 3 - i);
    count |= std::to_integer<std::size_t>(bytes[kCountAt + i]) << shift;
  }
  return count;
}

// Whether a file of `size` bytes holds `count` facets and, after them, less than another one.
bool fits(std::size_t size, std::size_t count) {
  const std::size_t expected = kHeaderBytes + kFacetBytes * count;
  return size == expected || (count > 0 && size > expected && size - expected < kFacetBytes);
}

// The attribute bytes of the facets, if the count of each one says how many follow it.
struct AttributeData {
  std::size_t bytes = 0;
  std::size_t first = 0;  // the first facet that has some
};

// Returns what fits the file's size. nullopt: there is none, or the counts are colours.
std::optional<AttributeData> attribute_data(std::span<const std::byte> bytes, std::size_t count) {
  AttributeData data;
  std::size_t end = kHeaderBytes;
  for (std::size_t facet = 0; facet < count; ++facet) {
    if (end > bytes.size() || bytes.size() - end < kFacetBytes) return std::nullopt;
    std::uint16_t more = 0;
    std::memcpy(&more, bytes.data() + end + kAttributeAt, sizeof more);
    if (data.bytes == 0) data.first = facet;
    data.bytes += more;
    end += kFacetBytes + more;
  }
  if (data.bytes == 0 || end > bytes.size()) return std::nullopt;
  // Less than a facet may follow the data, but not if the file then holds whole facets without them.
  const std::size_t left = bytes.size() - end;
  const bool whole_facets = (bytes.size() - kHeaderBytes) % kFacetBytes == 0;
  return left == 0 || (left < kFacetBytes && !whole_facets) ? std::optional(data) : std::nullopt;
}

Error wrong_count(const Source& source, std::size_t count) {
  const std::size_t size = source.bytes.size(), expected = kHeaderBytes + kFacetBytes * count;
  const std::size_t whole = (size - kHeaderBytes) / kFacetBytes;
  const bool holds_facets = whole > 0 && (size - kHeaderBytes) % kFacetBytes == 0;
  const std::string should = "the count of " + std::to_string(count) + " facets needs " + std::to_string(expected) +
                             " bytes, the file has " + std::to_string(size);
  if (size < expected) {
    return at_byte(source, size, ErrorCode::unreadable_mesh,
                   "truncated: " + should + (holds_facets ? " and holds " + std::to_string(whole) + " facets" : ""));
  }
  if (!holds_facets) return at_byte(source, expected, ErrorCode::unreadable_mesh, "left-over bytes: " + should);
  const std::string remedy = count == 0 ? "written to a pipe? Write it to a file, so that its header gets the count"
                                        : "write it again, so that both agree";
  return at_byte(source, kCountAt, ErrorCode::unreadable_mesh,
                 "the header counts " + std::to_string(count) + " facets, the file holds " + std::to_string(whole) +
                     ": " + remedy);
}

Result<Done> check_size(const Source& source) {
  const std::size_t size = source.bytes.size();
  if (size < kHeaderBytes) {
    return at_byte(source, size, ErrorCode::unreadable_mesh,
                   "truncated: a binary STL needs 84 bytes of header and a count");
  }
  const std::size_t count = facet_count(source.bytes, std::endian::little);
  if (size == kHeaderBytes + kFacetBytes * count) return Done{};
  if (const auto data = attribute_data(source.bytes, count)) {
    return at_byte(source, kHeaderBytes + kFacetBytes * (data->first + 1), ErrorCode::unsupported_format,
                   "attribute data after facets, which is not supported: " + std::to_string(data->bytes) +
                       " bytes, the first after facet " + std::to_string(data->first) + "; export without attributes");
  }
  if (fits(size, count)) return Done{};
  if (const std::size_t swapped = facet_count(source.bytes, std::endian::big); fits(size, swapped)) {
    return at_byte(source, kCountAt, ErrorCode::unsupported_format,
                   "big-endian numbers, which are not supported: the count of " + std::to_string(swapped) +
                       " facets fits the file in that order alone; export it as little-endian, as STL asks");
  }
  return wrong_count(source, count);
}

Error non_finite(const Source& source, std::size_t facet, const float* coordinates) {
  std::size_t k = 0;
  while (std::isfinite(coordinates[k])) ++k;
  return at_byte(source, kHeaderBytes + facet * kFacetBytes + kNormalBytes + k * sizeof(float),
                 ErrorCode::non_finite_vertex, "a coordinate of facet " + std::to_string(facet) + " is not finite");
}

}  // namespace

bool is_binary_stl(std::span<const std::byte> bytes) {
  return bytes.size() >= kHeaderBytes && fits(bytes.size(), facet_count(bytes, std::endian::little));
}

Result<ReadMesh> read_binary_stl(const Source& source) {
  if (auto ok = check_size(source); !ok) return std::move(ok).error();
  const std::size_t count = facet_count(source.bytes, std::endian::little);
  if (count > source.limits.max_triangles) return too_many(source, "triangles", source.limits.max_triangles);
  if (count > vertex_limit(source) / 3) return too_many(source, "vertices", vertex_limit(source));

  ReadMesh out;
  out.format = Format::stl;
  if (count == 0) return out;
  if (const std::size_t left = source.bytes.size() - kHeaderBytes - kFacetBytes * count; left != 0) {
    out.notes.remarks.push_back("bytes after the last of the " + std::to_string(count) +
                                " facets that the header announces, ignored: " + std::to_string(left));
  }
  reserve_room(out.mesh.positions, 3 * count);
  reserve_room(out.mesh.triangles, count);
  out.mesh.positions.resize(3 * count);  // Vec3 is not initialised, so this writes nothing
  const std::byte* facet = source.bytes.data() + kHeaderBytes + kNormalBytes;
  double* position = out.mesh.positions.data()->data();
  for (std::size_t i = 0; i < count; ++i, facet += kFacetBytes, position += 9) {
    std::array<float, 9> coordinates;
    std::memcpy(coordinates.data(), facet, sizeof coordinates);
    float nothing = 0;  // stays zero, unless a coordinate is NaN or infinite
    for (std::size_t k = 0; k < 9; ++k) {
      position[k] = static_cast<double>(coordinates[k]);
      nothing += coordinates[k] * 0.0F;
    }
    if (!(nothing == 0)) return non_finite(source, i, coordinates.data());
    const auto first = static_cast<std::uint32_t>(3 * i);
    out.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return out;
}

}  // namespace meshgauge::api
