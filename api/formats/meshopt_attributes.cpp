#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "api/formats/meshopt.h"
#include "api/formats/meshopt_bytes.h"

namespace meshgauge::api {
namespace {

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
