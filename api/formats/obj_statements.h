// The statements of OBJ other than those of vertices, faces, groups and objects: what each is of the surface.
#pragma once

#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "api/formats/unread.h"

namespace meshgauge::api {

enum class ObjRole {
  beside_points,  // says nothing of how vertices are joined: normals, materials
  attribute,      // no surface by itself: the body of a free-form surface, a quality of display
  line,           // points, lines and curves
  surface,        // a surface that is not read
  unknown,        // no word of the specification, or one that this file does not judge: it may be a surface
};

// Returns the role of a statement by its first word. Constant time.
ObjRole role_of_obj(std::string_view word);

// Returns true for a word that begins a statement of vertices, faces, groups, lines or surfaces.
bool is_shape(std::string_view word);

// Returns the statement for which an unknown word was probably meant: "f" for "F", "F1" and "f1,2,3". Readers that pass
// over such a word lose a face or shift the indices of all others. Empty: none.
std::string_view meant_statement(std::string_view word);

// Counts statements that are not read, by their first words. Borrows the words.
class UnreadStatements {
 public:
  // Constant time, without allocation beyond the first words.
  void add(std::string_view word);

  void move_to(Unread& unread);

 private:
  std::vector<std::pair<std::string_view, std::size_t>> words_;  // at most Unread::kMostKinds
  std::size_t others_ = 0;
};

}  // namespace meshgauge::api
