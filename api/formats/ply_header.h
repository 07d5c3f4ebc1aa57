// Reads the header of a PLY file: the elements that follow and the layout of their records.
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

}  // namespace meshgauge::api
