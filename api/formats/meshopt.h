// The streams of EXT_meshopt_compression and KHR_meshopt_compression, as the two extensions define them. Debian has
// libmeshoptimizer as a shared library alone, which the static reader of uploads cannot link, and in Debian 12 without
// version 1 of the attributes. The tests hold these decoders against it, bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace meshgauge::api {

// Each fills `out` and returns true, or returns false: the bytes are not a stream of as many elements. Time and memory
// are linear in `out`.

// Elements of `stride` bytes. Precondition: stride is a multiple of 4 from 4 to 256, out.size() is a multiple of it.
bool decode_meshopt_attributes(std::span<const std::byte> stream, std::size_t stride, std::span<std::byte> out);

// Indices of `index_bytes` bytes each, 2 or 4: of separate triangles, and in any order. Precondition: out.size() is a
// multiple of index_bytes, and of three times that for triangles.
bool decode_meshopt_triangles(std::span<const std::byte> stream, std::size_t index_bytes, std::span<std::byte> out);
bool decode_meshopt_indices(std::span<const std::byte> stream, std::size_t index_bytes, std::span<std::byte> out);

// The filters EXPONENTIAL (size a multiple of 4) and QUATERNION (a multiple of 8), undone in place.
void undo_meshopt_exponential(std::span<std::byte> data);
void undo_meshopt_quaternion(std::span<std::byte> data);

}  // namespace meshgauge::api
