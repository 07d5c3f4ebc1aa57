// Decodes the streams of EXT_meshopt_compression and KHR_meshopt_compression as the two extensions define them. Debian
// has libmeshoptimizer only as a shared library, which the static reader of uploads cannot link, and Debian 12 without
// version 1 of attributes. Tests compare these decoders with it, bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace meshgauge::api {

// Each decoder fills `out` and returns true; false: the bytes are not a stream of that many elements. Time and memory
// are linear in `out`.

// Decodes elements of `stride` bytes. Precondition: stride is a multiple of 4 from 4 to 256, out.size() a multiple of
// stride.
bool decode_meshopt_attributes(std::span<const std::byte> stream, std::size_t stride, std::span<std::byte> out);

// Decodes indices of 2 or 4 bytes each (`index_bytes`): of separate triangles, or a plain sequence. Precondition:
// out.size() is a multiple of index_bytes, for triangles of three times that.
bool decode_meshopt_triangles(std::span<const std::byte> stream, std::size_t index_bytes, std::span<std::byte> out);
bool decode_meshopt_indices(std::span<const std::byte> stream, std::size_t index_bytes, std::span<std::byte> out);

// Undo the filters EXPONENTIAL and QUATERNION in place. Precondition: the size is a multiple of 4 and of 8
// respectively.
void undo_meshopt_exponential(std::span<std::byte> data);
void undo_meshopt_quaternion(std::span<std::byte> data);

}  // namespace meshgauge::api
