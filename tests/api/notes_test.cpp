#include "api/notes.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using Notes = std::vector<std::string>;

TEST_CASE("notes: nothing is said of what did not happen") {
  api::MeshFacts mesh;
  mesh.vertices = 3;
  mesh.triangles = 1;
  mesh.notes.gzip = true;
  CHECK(api::notes_of(mesh).empty());
}

TEST_CASE("notes: a sentence for each thing that was done") {
  api::MeshFacts mesh;
  mesh.format = api::Format::three_mf;
  mesh.degenerate = 1;
  mesh.notes.welded_vertices = 2;
  mesh.notes.polygons.count = 3;
  mesh.notes.helper_objects = 6;
  mesh.notes.remarks = {"the file has a remark"};
  mesh.notes.skipped_primitives = 4;
  mesh.notes.unused_objects = 5;
  mesh.notes.filename_says = api::Format::stl;
  mesh.notes.media_type_says = api::Format::obj;
  CHECK(api::notes_of(mesh) ==
        Notes{"the file name says stl, the content is 3mf and was read as that",
              "the media type says obj, the content is 3mf and was read as that",
              "faces of more than three corners, split as fans from their first corner: 3",
              "points, lines, faces of fewer than three corners and joins of strips, left out for want of a surface: 4",
              "objects outside of the build or the scene, left out: 5",
              "objects and volumes that are not printed (support, modifiers, blockers), left out: 6",
              "vertices joined with another of exactly the same position: 2",
              "triangles without area, kept as the segment or the point they span: 1", "the file has a remark"});
}
