// The header of a PLY file: which elements follow, and how each record is laid out.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/formats/source.h"

namespace meshgauge::api {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline std::size_t size_of(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}
inline bool is_integer(PlyType type) { return type < PlyType::float32; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  // of the value, or of each item of the list
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  // of the list's length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_list() const;
  std::size_t least_bytes() const;  // of one binary record: its scalars, and its lists as if empty
};

enum class PlyEncoding { ascii, little_endian, big_endian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;  // names are unique, and those of properties within an element
  const char* body = nullptr;        // the first byte after the header
  std::size_t unknown_lines = 0;     // that begin with a word of no meaning, passed over
  std::string first_unknown;         // the word of the first, as in a message
};

// True when the bytes begin with "ply" and a line end.
bool is_ply(std::string_view text);

// A line that begins with a word of no meaning is passed over as a comment, unless it looks like a misspelt one. Lines
// end by \n or \r\n, even mixed, or all by \r. Anything not of format 1.0 is refused with its line.
Result<PlyHeader> read_ply_header(const Source& source);

}  // namespace meshgauge::api
