// One small file of every format and encoding: the input of the tests of damaged files and the seeds of fuzzing. A new
// format needs one row of the table in small_files.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meshgauge::api::test {

struct SmallFile {
  std::string name;  // its extension, before any ".gz", is the hint and the format's name
  std::string content;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  // Bytes at the end without effect on the mesh: a line end, a comment, a colour. Any other cut must be refused, unless
  // `whole_parts` is set.
  std::size_t spare = 0;
  // Vertices or triangles, at most, that one changed byte may add or lose without being noticed: a line of OBJ that
  // begins with another letter is ignored, a face of fewer corners is a smaller face.
  std::size_t unnoticed = 0;
  // Set if the format cannot tell a file cut between two parts from a whole one: the triangles of what is left.
  std::size_t (*whole_parts)(std::string_view left) = nullptr;
};

std::vector<SmallFile> small_files();

// The model inside the 3MF, which a checksum protects from damage.
std::string small_model();

// A model of a 3MF with elements and attributes of other namespaces, one of them not declared.
std::string small_foreign_model();

// The .gltf, a NUL, and the bytes of the file beside it: the input of targets/gltf_zip.cpp.
std::string small_scene_and_data();

// Zip archives that hold "a" and "b", by name: plain ones and Zip64.
std::vector<std::pair<std::string, std::string>> small_archives();

// "gltf" of "m.gltf.gz".
std::string format_of(const SmallFile& file);

}  // namespace meshgauge::api::test
