#include "api/formats/gltf/meshopt.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>
#include <meshoptimizer.h>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

using Stream = std::vector<unsigned char>;

std::span<const std::byte> bytes(const Stream& stream) { return std::as_bytes(std::span(stream)); }

// Compares a decoder with that of libmeshoptimizer: the same answer and, if both accept the stream, the same bytes.
template <class Ours, class Theirs>
bool agree(const Stream& stream, std::size_t size, const Ours& ours, const Theirs& theirs) {
  Stream a(size, 0xEE);
  Stream b(size, 0xEE);
  const bool taken = ours(bytes(stream), std::as_writable_bytes(std::span(a)));
  const bool expected = theirs(b.data(), stream.data(), stream.size()) == 0;
  return taken == expected && (!taken || a == b);
}

bool agree_on_attributes(const Stream& stream, std::size_t count, std::size_t stride) {
  return agree(
      stream, count * stride, [&](auto in, auto out) { return decode_meshopt_attributes(in, stride, out); },
      [&](auto* out, auto* in, auto size) { return meshopt_decodeVertexBuffer(out, count, stride, in, size); });
}

bool agree_on_triangles(const Stream& stream, std::size_t count, std::size_t width) {
  return agree(
      stream, count * width, [&](auto in, auto out) { return decode_meshopt_triangles(in, width, out); },
      [&](auto* out, auto* in, auto size) { return meshopt_decodeIndexBuffer(out, count, width, in, size); });
}

bool agree_on_indices(const Stream& stream, std::size_t count, std::size_t width) {
  return agree(
      stream, count * width, [&](auto in, auto out) { return decode_meshopt_indices(in, width, out); },
      [&](auto* out, auto* in, auto size) { return meshopt_decodeIndexSequence(out, count, width, in, size); });
}

// Vertices whose bytes differ by little, by much, and not at all.
Stream vertices(std::mt19937& dice, std::size_t count, std::size_t stride) {
  Stream out(count * stride);
  for (std::size_t k = 0; k < stride; ++k) {
    const unsigned span = 1U << dice() % 9;
    auto value = static_cast<unsigned>(dice());
    for (std::size_t i = 0; i < count; ++i) {
      value += static_cast<unsigned>(dice()) % span;
      out[i * stride + k] = static_cast<unsigned char>(value);
    }
  }
  return out;
}

Stream encoded_vertices(const Stream& data, std::size_t count, std::size_t stride) {
  Stream out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data.data(), count, stride));
  return out;
}

// A strip of squares over `columns`, with some triangles rotated and some random ones.
std::vector<unsigned> triangles(std::mt19937& dice, unsigned count, unsigned columns) {
  std::vector<unsigned> out;
  for (unsigned t = 0; t < count; ++t) {
    const unsigned first = t / 2 + t / columns;
    std::vector<unsigned> corners = {first, first + 1 + t % 2, first + columns + t % 2};
    if (dice() % 8 == 0) corners = {unsigned(dice()) % 60'000, first, unsigned(dice()) % 60'000};
    std::rotate(corners.begin(), corners.begin() + static_cast<int>(dice() % 3), corners.end());
    out.insert(out.end(), corners.begin(), corners.end());
  }
  return out;
}

// One byte of the stream changed, and the stream cut or grown.
template <class Agree>
void damage(std::mt19937& dice, const Stream& whole, const Agree& agree) {
  for (int i = 0; i < 60; ++i) {
    Stream stream = whole;
    stream[dice() % stream.size()] ^= static_cast<unsigned char>(1U << dice() % 8);
    CHECK(agree(stream));
    stream.resize(dice() % (whole.size() + 3), static_cast<unsigned char>(dice()));
    CHECK(agree(stream));
  }
}

Stream from_hex(std::string_view hex) {
  Stream out;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    out.push_back(static_cast<unsigned char>(std::stoul(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return out;
}

}  // namespace

TEST_CASE("meshopt: attributes are decoded as libmeshoptimizer decodes them, whole and damaged") {
  std::mt19937 dice(1);
  for (const std::size_t stride : {4U, 8U, 12U, 16U, 20U, 64U, 252U, 256U}) {
    for (const std::size_t count : {0U, 1U, 15U, 16U, 17U, 255U, 256U, 257U, 1000U}) {
      const Stream data = vertices(dice, count, stride);
      const Stream stream = encoded_vertices(data, count, stride);
      Stream out(data.size());
      CHECK(decode_meshopt_attributes(bytes(stream), stride, std::as_writable_bytes(std::span(out))));
      CHECK(out == data);
      damage(dice, stream, [&](const Stream& damaged) { return agree_on_attributes(damaged, count, stride); });
    }
  }
}

// Written by meshoptimizer 1.2, since the version of Debian 12 does not know it: 40 elements, at its three levels, with
// components as bytes, as 16-bit words and as rotated 32-bit words.
TEST_CASE("meshopt: attributes of version 1") {
  Stream expected;
  for (unsigned i = 0; i < 40; ++i) {
    const auto words = {static_cast<std::uint16_t>(i * i), static_cast<std::uint16_t>(1000 - 3 * i),
                        static_cast<std::uint16_t>(i % 7 * 257), std::uint16_t{5}};
    std::string element;
    for (const std::uint16_t word : words) element += raw(word);
    element += raw(0.25F * static_cast<float>(i) - 3) + raw(0x9E3779B9U * (i / 5));
    expected.insert(expected.end(), element.begin(), element.end());
  }
  const char* const streams[] = {
      "A193A53A550002060A0E12161A1E22262A2E32363A3E42464A4E52565A5E62666A6E72767A7E82868A8E92969A28800200808080"
      "00002A055555555555555555555555555555555555555500000000152AABAAAE0B0BAABAAAEA0B0BABAA00000B152AABAAAE0B0B"
      "AABAAAEA0B0BABAA00000B001F1F1F1F3F3F3F3F7F7FFFFFFFFF8080404040402020202020202020101010101010101010101006"
      "001001F8847C1000020020848D8D8D10428D8D8D08008D002084F2F4F41042F2F4F40800F40020846E6E7010426E706E08007000"
      "2084C3C3C31042C3C1C30800C3000000000000E80300000500000040C00000000000000000",
      "A19BA53A550002060A0E12161A1E22262A2E32363A3E42464A4E52565A5E62666A6E72767A7E82868A8E92969A2A055555555555"
      "555555555555555555555555555500000000152AABAAAE0B0BAABAAAEA0B0BABAA00000B152AABAAAE0B0BAABAAAEA0B0BABAA00"
      "000B001F1F1F1F3F3F3F3F7F7FFF00000080804040404020202020202020201010101010101010101010010070837D010020848D"
      "8D8D10428D8D8D08008D002084F2F4F41042F2F4F40800F40020846E6E7010426E706E080070002084C3C3C31042C3C1C30800C3"
      "000000000000E80300000500000040C00000000001000100",
      "A19BA568550002060A0E12161A1E22262A2E32363A3E42464A4E52565A5E62666A6E72767A7E82868A8E92969A2A055555555555"
      "555555555555555555555555555500000000152AABAAAE0B0BAABAAAEA0B0BABAA00000B152AABAAAE0B0BAABAAAEA0B0BABAA00"
      "000B0520300F170710000F1A0E262F4C4F8FFFF8FC1830D0D030F4C4F262E262F13118FC1EDDDD000007030F030020848D8D8D10"
      "428D8D8D08008D002084F2F4F41042F2F4F40800F40020846E6E7010426E706E080070002084C3C3C31042C3C1C30800C3000000"
      "000000E80300000500000040C00000000001005200"};
  for (const char* hex : streams) {
    Stream stream = from_hex(hex);
    Stream out(expected.size());
    CHECK(decode_meshopt_attributes(bytes(stream), 16, std::as_writable_bytes(std::span(out))));
    CHECK(out == expected);
    for (std::size_t length = 0; length < stream.size(); ++length) {
      const Stream cut(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(length));
      CHECK(!decode_meshopt_attributes(bytes(cut), 16, std::as_writable_bytes(std::span(out))));
    }
    stream.end()[-4] = 3;  // a channel that does not exist
    CHECK(!decode_meshopt_attributes(bytes(stream), 16, std::as_writable_bytes(std::span(out))));
  }
}

TEST_CASE("meshopt: indices are decoded as libmeshoptimizer decodes them, whole and damaged") {
  std::mt19937 dice(2);
  for (const unsigned count : {0U, 1U, 2U, 17U, 500U}) {
    for (const int version : {0, 1}) {
      meshopt_encodeIndexVersion(version);
      const auto indices = triangles(dice, count, 9);
      Stream stream(meshopt_encodeIndexBufferBound(indices.size(), 70'000));
      stream.resize(meshopt_encodeIndexBuffer(stream.data(), stream.size(), indices.data(), indices.size()));
      Stream sequence(meshopt_encodeIndexSequenceBound(indices.size(), 70'000));
      sequence.resize(meshopt_encodeIndexSequence(sequence.data(), sequence.size(), indices.data(), indices.size()));
      for (const std::size_t width : {2U, 4U}) {
        CHECK(agree_on_triangles(stream, indices.size(), width));
        CHECK(agree_on_indices(sequence, indices.size(), width));
        damage(dice, stream, [&](const Stream& s) { return agree_on_triangles(s, indices.size(), width); });
        damage(dice, sequence, [&](const Stream& s) { return agree_on_indices(s, indices.size(), width); });
      }
      std::vector<unsigned> out(indices.size());
      CHECK(decode_meshopt_indices(bytes(sequence), 4, std::as_writable_bytes(std::span(out))));
      CHECK(out == indices);
    }
  }
}

TEST_CASE("meshopt: the filters are undone as libmeshoptimizer undoes them") {
  std::mt19937 dice(3);
  Stream data(4 * 4096);
  for (unsigned char& byte : data) byte = static_cast<unsigned char>(dice());
  Stream exponential = data;
  undo_meshopt_exponential(std::as_writable_bytes(std::span(exponential)));
  Stream expected = data;
  meshopt_decodeFilterExp(expected.data(), 4096, 4);
  CHECK(exponential == expected);

  std::vector<float> quaternions;
  for (int i = 0; i < 1000; ++i) {
    float q[4];
    float norm = 0;
    for (float& c : q) {
      c = static_cast<float>(dice()) / 4e9F - 0.5F;
      norm += c * c;
    }
    for (const float c : q) quaternions.push_back(c / std::sqrt(norm));
  }
  std::vector<std::int16_t> ours(4000);
  meshopt_encodeFilterQuat(ours.data(), 1000, 8, 12, quaternions.data());
  std::vector<std::int16_t> theirs = ours;
  undo_meshopt_quaternion(std::as_writable_bytes(std::span(ours)));
  meshopt_decodeFilterQuat(theirs.data(), 1000, 8);
  // Versions of the library differ in the last of 16 bits, by the order of their float arithmetic.
  for (std::size_t i = 0; i < ours.size(); ++i) CHECK(std::abs(ours[i] - theirs[i]) <= 1);
}

}  // namespace meshgauge::api::test
