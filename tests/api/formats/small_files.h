// One small file of every format and encoding, made here: what the tests of damaged files damage, and what fuzzing
// starts from. A new format is one row of the table in small_files.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meshgauge::api::test {

struct SmallFile {
  std::string name;  // its end is the hint, and before ".gz" the name of the format
  std::string content;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  // Bytes at its end on which no mesh depends: a line end, a comment, a colour. Any other cut must be refused, unless
  // `whole_parts` is set.
  std::size_t spare = 0;
  // Vertices or triangles, at most, that one changed byte may add or lose without being noticed: a line of OBJ that
  // begins with another letter is passed over, a face of fewer corners is a smaller face.
  std::size_t unnoticed = 0;
  // Set where a format cannot tell a file that is cut between two of its parts from a whole one: the triangles of what
  // is left.
  std::size_t (*whole_parts)(std::string_view left) = nullptr;
};

std::vector<SmallFile> small_files();

// The model inside of the 3MF: what a checksum keeps all damage from.
std::string small_model();

// The .gltf with a file beside it and, behind a NUL, the bytes of that: what targets/gltf_zip.cpp puts together.
std::string small_scene_and_data();

// Zip archives that hold "a" and "b", by name: plain ones and Zip64.
std::vector<std::pair<std::string, std::string>> small_archives();

// "gltf" of "m.gltf.gz".
std::string format_of(const SmallFile& file);

}  // namespace meshgauge::api::test
