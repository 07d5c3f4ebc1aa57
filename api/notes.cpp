#include "api/notes.h"

namespace meshgauge::api {
namespace {

void add_count(std::vector<std::string>& notes, const char* what, std::size_t count) {
  if (count != 0) notes.push_back(what + (": " + std::to_string(count)));
}

void add_contradiction(std::vector<std::string>& notes, const char* who, std::optional<Format> said, Format is) {
  if (!said) return;
  notes.push_back(std::string(who) + " says " + std::string(to_string(*said)) + ", the content is " +
                  std::string(to_string(is)) + " and was read as that");
}

}  // namespace

std::vector<std::string> notes_of(const MeshFacts& mesh) {
  std::vector<std::string> notes;
  add_contradiction(notes, "the file name", mesh.notes.filename_says, mesh.format);
  add_contradiction(notes, "the media type", mesh.notes.media_type_says, mesh.format);
  if (mesh.notes.unit) {
    notes.push_back("the unit of the file is " + std::string(to_string(*mesh.notes.unit)) +
                    "; all lengths are in millimetres");
  }
  add_count(notes, "faces of more than three corners, split as fans from their first corner", mesh.notes.polygons.count);
  add_count(notes,
            "points, lines, faces of fewer than three corners and joins of strips, left out for want of a surface",
            mesh.notes.skipped_primitives);
  add_count(notes, "objects outside of the build or the scene, left out", mesh.notes.unused_objects);
  add_count(notes, "objects and volumes that are not printed (support, modifiers, blockers), left out",
            mesh.notes.helper_objects);
  add_count(notes, "vertices joined with another of exactly the same position", mesh.notes.welded_vertices);
  add_count(notes, "triangles without area, kept as the segment or the point they span", mesh.degenerate);
  notes.insert(notes.end(), mesh.notes.remarks.begin(), mesh.notes.remarks.end());
  return notes;
}

}  // namespace meshgauge::api
