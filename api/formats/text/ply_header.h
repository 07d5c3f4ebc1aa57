// Reads the header of a PLY file: the elements that follow, the layout of their records, and which of them are surface.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/formats/file/source.h"

namespace meshgauge::api {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline std::size_t size_of(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}
inline bool is_integer(PlyType type) { return type < PlyType::float32; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  // type of the value, or of each item of the list
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  // type of the list's length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  std::size_t least_bytes() const;  // size of one binary record with empty lists
};

enum class PlyEncoding { ascii, little_endian, big_endian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;  // with unique names; properties have unique names within an element
  const char* body = nullptr;        // the first byte after the header
  std::size_t unknown_lines = 0;     // ignored lines that begin with an unknown word
  std::string first_unknown;         // first word of the first such line, quoted for a message
};

// Returns true when the bytes begin with the word "ply", after a byte order mark or without one.
bool is_ply(std::string_view text);

// Reads the header. Ignores a line that begins with an unknown word, unless the word looks like a misspelt keyword.
// Lines end with \n or \r\n, even mixed, or all with \r. Refuses what is not format 1.0, with the line.
Result<PlyHeader> read_ply_header(const Source& source);

// Borrows from the header.
struct PlyLayout {
  const PlyElement* vertex = nullptr;          // has scalars x, y and z
  const PlyProperty* face_corners = nullptr;   // list of integers in the element "face"; nullptr: no faces
  const PlyProperty* strip_corners = nullptr;  // list of integers in the element "tristrips"; nullptr: no strips
  bool only_points = false;                    // no element that may join vertices, but faces and strips
  std::size_t lines = 0;                       // in elements of edges and lines
  Unread unread;                               // elements that may be surface, under other names
};

// Whether a property of faces or strips, other than their corners, may be part of the surface: a list of integers whose
// name has nothing of normals, textures, colours or materials. Such a list may hold corners, of holes for example.
bool may_hold_corners(const PlyProperty& property);

// Returns the layout. Error: no element "vertex" with coordinates, or neither triangles, nor points alone, nor what may
// be surface and is not read.
Result<PlyLayout> find_layout(const Source& source, const PlyHeader& header);

}  // namespace meshgauge::api
