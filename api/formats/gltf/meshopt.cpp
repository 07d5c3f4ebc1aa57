#include "api/formats/gltf/meshopt.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace meshgauge::api {
namespace {

// Reads the bytes of a stream in order.
class MeshoptBytes {
 public:
  explicit MeshoptBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}

  // Returns the next `count` bytes, valid as long as the stream. nullptr: fewer are left.
  const std::byte* take(std::size_t count) {
    if (count > bytes_.size() - at_) return nullptr;
    const std::byte* taken = bytes_.data() + at_;
    at_ += count;
    return taken;
  }

  bool take_byte(std::uint8_t& out) {
    const std::byte* taken = take(1);
    if (taken != nullptr) out = static_cast<std::uint8_t>(*taken);
    return taken != nullptr;
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

constexpr unsigned kHeader = 0xA0;
constexpr std::size_t kGroup = 16;
constexpr std::size_t kMostInBlock = 256;
constexpr std::size_t kBlockBytes = 8192;
constexpr std::size_t kLeastTail[] = {32, 24};  // [version]

// Bits per value by the two bits of a group's header. Row 0: version 0; rows 1 and 2: version 1, control 0 and 1.
constexpr unsigned kBits[3][4] = {{0, 2, 4, 8}, {0, 1, 2, 4}, {1, 2, 4, 8}};

unsigned byte_at(const std::byte* bytes, std::size_t i) { return std::to_integer<unsigned>(bytes[i]); }

// Reads sixteen values of `bits` bits. The greatest value means that a byte after the group holds the value.
bool take_group(MeshoptBytes& in, unsigned bits, std::uint8_t* out) {
  if (bits == 0) return std::fill_n(out, kGroup, std::uint8_t{0}), true;
  const std::byte* packed = in.take(2 * bits);
  if (packed == nullptr) return false;
  if (bits == 8) return std::memcpy(out, packed, kGroup), true;
  const unsigned escape = (1U << bits) - 1;
  for (unsigned i = 0; i < kGroup; ++i) {
    const unsigned from_low = i * bits % 8;
    const unsigned shift = bits == 1 ? from_low : 8 - bits - from_low;  // single bits start at the low end
    const unsigned value = (byte_at(packed, i * bits / 8) >> shift) & escape;
    out[i] = static_cast<std::uint8_t>(value);
    if (value == escape && !in.take_byte(out[i])) return false;
  }
  return true;
}

// One byte for each element of a block.
using Plane = std::array<std::uint8_t, kMostInBlock>;

bool take_groups(MeshoptBytes& in, std::size_t count, const unsigned (&bits)[4], Plane& plane) {
  const std::size_t groups = (count + kGroup - 1) / kGroup;
  const std::byte* header = in.take((groups + 3) / 4);
  if (header == nullptr) return false;
  for (std::size_t group = 0; group < groups; ++group) {
    const unsigned kind = (byte_at(header, group / 4) >> (group % 4 * 2)) & 3U;
    if (!take_group(in, bits[kind], plane.data() + group * kGroup)) return false;
  }
  return true;
}

bool take_plane(MeshoptBytes& in, std::size_t count, unsigned version, unsigned control, Plane& plane) {
  if (version == 0) return take_groups(in, count, kBits[0], plane);
  if (control < 2) return take_groups(in, count, kBits[1 + control], plane);
  if (control == 2) return plane.fill(0), true;
  const std::byte* plain = in.take(count);
  if (plain != nullptr) std::memcpy(plane.data(), plain, count);
  return plain != nullptr;
}

// Sums the differences of one component. `planes`: its bytes, lowest first. `at`: the component in the first element;
// `last`: in the element before.
template <class T, class Next>
void add_up(const Plane* planes, std::size_t count, std::size_t stride, const std::byte* last, std::byte* at,
            const Next& next) {
  T value = 0;
  std::memcpy(&value, last, sizeof value);
  for (std::size_t i = 0; i < count; ++i, at += stride) {
    std::uint32_t difference = 0;
    for (unsigned j = 0; j < sizeof(T); ++j) difference |= std::uint32_t{planes[j][i]} << 8 * j;
    value = next(value, static_cast<T>(difference));
    std::memcpy(at, &value, sizeof value);
  }
}

template <class T>
T add_zigzag(T value, T difference) {
  const std::uint32_t wide = difference;
  return static_cast<T>(value + ((0U - (wide & 1U)) ^ (wide >> 1U)));
}

class Attributes {
 public:
  Attributes(MeshoptBytes in, unsigned version, std::size_t stride, std::span<const std::byte> tail)
      : in_(in), version_(version), stride_(stride), channels_(tail.subspan(stride)) {
    std::ranges::copy(tail.first(stride), last_.begin());
  }

  bool decode(std::span<std::byte> out) {
    const std::size_t block = std::min(kMostInBlock, kBlockBytes / stride_ / kGroup * kGroup) * stride_;
    for (std::size_t at = 0; at < out.size(); at += block) {
      if (!decode_block(out.subspan(at, std::min(block, out.size() - at)))) return false;
    }
    return in_.at_end();
  }

 private:
  bool decode_block(std::span<std::byte> out) {
    const std::size_t count = out.size() / stride_;
    const std::byte* controls = in_.take(version_ == 0 ? 0 : stride_ / 4);
    if (controls == nullptr) return false;
    std::array<Plane, 4> planes;
    for (std::size_t k = 0; k < stride_; k += 4) {
      const unsigned control = version_ == 0 ? 0 : byte_at(controls, k / 4);
      for (unsigned j = 0; j < 4; ++j) {
        if (!take_plane(in_, count, version_, (control >> 2 * j) & 3U, planes[j])) return false;
      }
      if (!add_up_word(planes, count, k, out)) return false;
    }
    std::ranges::copy(out.last(stride_), last_.begin());
    return true;
  }

  // Decodes the four bytes at `k` of each element: as bytes, as 16-bit words or as one 32-bit word.
  bool add_up_word(const std::array<Plane, 4>& planes, std::size_t count, std::size_t k, std::span<std::byte> out) {
    const unsigned channel = version_ == 0 ? 0 : byte_at(channels_.data(), k / 4);
    switch (channel & 3U) {
      case 0:
        for (std::size_t j = 0; j < 4; ++j) {
          add_up<std::uint8_t>(&planes[j], count, stride_, &last_[k + j], &out[k + j], add_zigzag<std::uint8_t>);
        }
        return true;
      case 1:
        for (std::size_t j = 0; j < 4; j += 2) {
          add_up<std::uint16_t>(&planes[j], count, stride_, &last_[k + j], &out[k + j], add_zigzag<std::uint16_t>);
        }
        return true;
      case 2:
        add_up<std::uint32_t>(planes.data(), count, stride_, &last_[k], &out[k],
                              [turn = static_cast<int>(channel >> 4U)](std::uint32_t value, std::uint32_t difference) {
                                return value ^ std::rotr(difference, turn);
                              });
        return true;
      default:
        return false;
    }
  }

  MeshoptBytes in_;
  unsigned version_;
  std::size_t stride_;
  std::array<std::byte, 256> last_{};
  std::span<const std::byte> channels_;  // version 1: one for each four bytes
};

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

// Stream: a header of one byte, the blocks, and a tail with the element before the first and the channels.
bool decode_meshopt_attributes(std::span<const std::byte> stream, std::size_t stride, std::span<std::byte> out) {
  if (stream.empty() || (static_cast<unsigned>(stream[0]) & 0xF0U) != kHeader) return false;
  const unsigned version = static_cast<unsigned>(stream[0]) & 0x0FU;
  if (version > 1) return false;
  const std::size_t tail = stride + (version == 0 ? 0 : stride / 4);
  const std::size_t padded = std::max(tail, kLeastTail[version]);
  if (stream.size() - 1 < padded) return false;
  const MeshoptBytes blocks(stream.subspan(1, stream.size() - 1 - padded));
  return Attributes(blocks, version, stride, stream.last(tail)).decode(out);
}

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

// Converts a signed 8-bit exponent above a signed 24-bit mantissa to float.
void undo_meshopt_exponential(std::span<std::byte> data) {
  for (std::size_t at = 0; at < data.size(); at += 4) {
    std::uint32_t stored = 0;
    std::memcpy(&stored, &data[at], 4);
    const auto mantissa = static_cast<float>(static_cast<std::int32_t>(stored << 8U) >> 8);
    const std::uint32_t exponent = static_cast<std::uint32_t>((static_cast<std::int32_t>(stored) >> 24) + 127) << 23U;
    const float value = std::bit_cast<float>(exponent) * mantissa;
    std::memcpy(&data[at], &value, 4);
  }
}

// Restores a unit quaternion from its components without the greatest; the fourth value holds their scale and, in its
// lowest two bits, the index of the one left out.
void undo_meshopt_quaternion(std::span<std::byte> data) {
  for (std::size_t at = 0; at < data.size(); at += 8) {
    std::array<std::int16_t, 4> stored{};
    std::memcpy(stored.data(), &data[at], 8);
    const auto one = static_cast<float>(stored[3] | 3);
    const float scale = 1.0F / std::sqrt(2.0F) / one;
    const std::array<float, 3> kept = {static_cast<float>(stored[0]) * scale, static_cast<float>(stored[1]) * scale,
                                       static_cast<float>(stored[2]) * scale};
    const float rest = 1.0F - (kept[0] * kept[0] + (kept[1] * kept[1] + kept[2] * kept[2]));
    const auto greatest = static_cast<std::size_t>(stored[3] & 3);
    const auto store = [&](std::size_t component, float value) {
      const auto whole = static_cast<std::int16_t>(std::lrint(value * 32767.0F));
      std::memcpy(&data[at + 2 * ((greatest + component) % 4)], &whole, 2);
    };
    store(0, std::sqrt(std::max(rest, 0.0F)));
    for (std::size_t i = 0; i < 3; ++i) store(i + 1, kept[i]);
  }
}

}  // namespace meshgauge::api
