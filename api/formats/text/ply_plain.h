// Reads the records of a binary PLY that nearly all files have, many at a time: vertices without lists, and triangles.
// Any other record is left to the reader of single values, which also names what is wrong. Little endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "api/formats/text/ply_header.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// Vertices of fixed size, whose x, y and z are all float or all double.
struct PlainVertices {
  std::size_t record_bytes = 0;
  std::size_t at[3] = {};  // offsets of x, y and z
  bool is_double = false;
};

// nullopt: the element's records are of another kind. Precondition: it has scalars x, y and z.
std::optional<PlainVertices> plain_vertices(const PlyElement& element);

// Reads `count` records to `to`. Returns false when a coordinate is not finite. Precondition: `bytes` holds them.
bool read_vertices(const char* bytes, const PlainVertices& records, std::size_t count, Vec3* to);

// Faces with one list of 32-bit indices, whose length is a byte or 32 bits, beside scalars.
struct PlainFaces {
  std::size_t length_at = 0;
  std::size_t length_bytes = 0;
  std::size_t triangle_bytes = 0;   // of the record of a triangle
  std::size_t last_bytes = 0;       // of its last value
  std::uint64_t most_vertices = 0;  // that the type of the indices can name
};

// nullopt: the element's records are of another kind. `corners`: its list of corners.
std::optional<PlainFaces> plain_faces(const PlyElement& element, const PlyProperty* corners);

// Appends the triangles of the next records, at most `most`. Returns their number: it ends before a record that is no
// triangle, or that has an index of `vertices` or more. Precondition: `bytes` holds `most` triangles.
std::size_t read_triangles(const char* bytes, const PlainFaces& records, std::size_t most, std::uint64_t vertices,
                           std::vector<Triangle>& to);

}  // namespace meshgauge::api
