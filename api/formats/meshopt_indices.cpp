#include <array>
#include <cstring>

#include "api/formats/meshopt.h"
#include "api/formats/meshopt_bytes.h"

namespace meshgauge::api {
namespace {

constexpr unsigned kTrianglesHeader = 0xE0;
constexpr unsigned kIndicesHeader = 0xD0;
constexpr unsigned kNewestVersion = 1;
constexpr std::size_t kTableBytes = 16;
constexpr std::size_t kIndicesTail = 4;

bool is_version_of(unsigned header, std::byte first) {
  const auto byte = static_cast<unsigned>(first);
  return (byte & 0xF0U) == header && (byte & 0x0FU) <= kNewestVersion;
}

// Reads a number of seven bits per byte, lowest first, in at most five bytes.
bool take_number(MeshoptBytes& in, std::uint32_t& out) {
  out = 0;
  for (unsigned shift = 0; shift < 35; shift += 7) {
    std::uint8_t byte = 0;
    if (!in.take_byte(byte)) return false;
    out |= static_cast<std::uint32_t>(byte & 127U) << shift;
    if (byte < 128) break;
  }
  return true;
}

std::uint32_t unzigzag(std::uint32_t value) { return (value >> 1U) ^ (0U - (value & 1U)); }

void store_index(std::byte* at, std::size_t index_bytes, std::uint32_t index) {
  const auto narrow = static_cast<std::uint16_t>(index);
  if (index_bytes == 2) std::memcpy(at, &narrow, 2);
  if (index_bytes == 4) std::memcpy(at, &index, 4);
}

// Decodes triangles relative to recent edges and vertices. Each code is one byte; the data follow all codes.
class Triangles {
 public:
  Triangles(MeshoptBytes in, const std::byte* table, unsigned version)
      : in_(in), table_(table), fresh_codes_(version >= 1 ? 13 : 15) {
    edges_.fill({~0U, ~0U});
    vertices_.fill(~0U);
  }

  bool decode(std::span<const std::byte> codes, std::size_t index_bytes, std::byte* out) {
    for (const std::byte code : codes) {
      if (!decode_triangle(static_cast<unsigned>(code))) return false;
      for (const std::uint32_t corner : corners_) {
        store_index(out, index_bytes, corner);
        out += index_bytes;
      }
    }
    return in_.at_end();
  }

 private:
  bool decode_triangle(unsigned code) {
    if (code < 0xF0) return beside_edge(code >> 4U, code & 15U);
    if (code < 0xFE) return apart(0, static_cast<unsigned>(table_[code & 15U]), false);
    std::uint8_t codes = 0;
    if (!in_.take_byte(codes)) return false;
    if (codes == 0) next_ = 0;
    return apart(code == 0xFE ? 0 : 15, codes, true);
  }

  // Decodes a triangle on one of the last sixteen edges. Its third corner is new, a recent vertex or an explicit index.
  bool beside_edge(unsigned edge, unsigned code) {
    const auto [a, b] = edges_[(edge_end_ - 1 - edge) & 15U];
    std::uint32_t c = 0;
    if (code < fresh_codes_) {
      c = code == 0 ? next_++ : vertices_[(vertex_end_ - 1 - code) & 15U];
    } else if (code == 15) {
      if (!take_index(c)) return false;
    } else {
      c = last_ = last_ + code * 2 - 27;  // code 13: one less, 14: one more
    }
    push_vertex(c, code == 0 || code >= fresh_codes_);
    push_edge(c, b);
    push_edge(a, c);
    corners_ = {a, b, c};
    return true;
  }

  // Decodes a triangle on no recent edge. Each corner is new (0), an explicit index (15, if `free`) or a recent vertex.
  bool apart(unsigned code_a, unsigned codes, bool free) {
    const unsigned code_b = codes >> 4U;
    const unsigned code_c = codes & 15U;
    std::uint32_t a = code_a == 0 ? next_++ : 0;
    std::uint32_t b = code_b == 0 ? next_++ : vertices_[(vertex_end_ - code_b) & 15U];
    std::uint32_t c = code_c == 0 ? next_++ : vertices_[(vertex_end_ - code_c) & 15U];
    if (free) {
      if (code_a == 15 && !take_index(a)) return false;
      if (code_b == 15 && !take_index(b)) return false;
      if (code_c == 15 && !take_index(c)) return false;
    }
    push_vertex(a, true);
    push_vertex(b, code_b == 0 || (free && code_b == 15));
    push_vertex(c, code_c == 0 || (free && code_c == 15));
    push_edge(b, a);
    push_edge(c, b);
    push_edge(a, c);
    corners_ = {a, b, c};
    return true;
  }

  bool take_index(std::uint32_t& out) {
    std::uint32_t difference = 0;
    if (!take_number(in_, difference)) return false;
    out = last_ = last_ + unzigzag(difference);
    return true;
  }

  // Unless `stays`, the next vertex overwrites this one.
  void push_vertex(std::uint32_t vertex, bool stays) {
    vertices_[vertex_end_] = vertex;
    vertex_end_ = (vertex_end_ + (stays ? 1U : 0U)) & 15U;
  }
  void push_edge(std::uint32_t a, std::uint32_t b) {
    edges_[edge_end_] = {a, b};
    edge_end_ = (edge_end_ + 1) & 15U;
  }

  MeshoptBytes in_;
  const std::byte* table_;
  unsigned fresh_codes_;
  std::array<std::array<std::uint32_t, 2>, 16> edges_;
  std::array<std::uint32_t, 16> vertices_;
  unsigned edge_end_ = 0;
  unsigned vertex_end_ = 0;
  std::uint32_t next_ = 0;
  std::uint32_t last_ = 0;
  std::array<std::uint32_t, 3> corners_{};
};

}  // namespace

// Stream: a header of one byte, a code for each triangle, their data and a table of codes.
bool decode_meshopt_triangles(std::span<const std::byte> stream, std::size_t index_bytes, std::span<std::byte> out) {
  const std::size_t count = out.size() / index_bytes / 3;
  if (stream.size() < 1 + kTableBytes || stream.size() - 1 - kTableBytes < count) return false;
  if (!is_version_of(kTrianglesHeader, stream[0])) return false;
  const MeshoptBytes data(stream.subspan(1 + count, stream.size() - 1 - count - kTableBytes));
  const std::byte* table = stream.last(kTableBytes).data();
  Triangles triangles(data, table, static_cast<unsigned>(stream[0]) & 0x0FU);
  return triangles.decode(stream.subspan(1, count), index_bytes, out.data());
}

// Stream: a header of one byte, differences to one of two last indices, and an unused tail.
bool decode_meshopt_indices(std::span<const std::byte> stream, std::size_t index_bytes, std::span<std::byte> out) {
  const std::size_t count = out.size() / index_bytes;
  if (stream.size() < 1 + kIndicesTail || stream.size() - 1 - kIndicesTail < count) return false;
  if (!is_version_of(kIndicesHeader, stream[0])) return false;
  MeshoptBytes data(stream.subspan(1, stream.size() - 1 - kIndicesTail));
  std::uint32_t last[2] = {};
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t number = 0;
    if (!take_number(data, number)) return false;
    std::uint32_t& base = last[number & 1U];
    base += unzigzag(number >> 1U);
    store_index(out.data() + i * index_bytes, index_bytes, base);
  }
  return data.at_end();
}

}  // namespace meshgauge::api
