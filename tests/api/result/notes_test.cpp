#include "api/result/notes.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using Notes = std::vector<std::string>;

TEST_CASE("notes: there is no note for a count of 0") {
  api::MeshFacts mesh;
  mesh.vertices = 3;
  mesh.triangles = 1;
  mesh.notes.gzip = true;
  CHECK(api::notes_of(mesh).empty());
}

TEST_CASE("notes: there is a sentence for each count") {
  api::MeshFacts mesh;
  mesh.format = api::Format::three_mf;
  mesh.degenerate = 1;
  mesh.notes.welded_vertices = 2;
  mesh.notes.polygons = {3, 2, 1, 7, 0.25};
  mesh.notes.helper_objects = 6;
  mesh.notes.remarks = {"the file has a remark"};
  mesh.notes.skipped_primitives = 4;
  mesh.notes.unused_objects = 5;
  mesh.notes.filename_says = api::Format::stl;
  mesh.notes.media_type_says = api::Format::obj;
  CHECK(api::notes_of(mesh) ==
        Notes{"the file name says stl, but the content is 3mf; it was read as that",
              "the media type says obj, but the content is 3mf; it was read as that",
              "faces of more than three corners, split into triangles: 3",
              "concave faces among them, split by ear clipping: 2",
              "faces that cross themselves, whose surface is ambiguous: 7",
              "faces that are not planar, whose surface is ambiguous (two splits of a face are at most 0.25 apart): 1",
              "points, lines, faces of fewer than three corners and joins of strips, left out, since they have no "
              "surface: 4",
              "objects outside of the build or the scene, left out: 5",
              "objects and volumes that are not printed (support, modifiers, blockers), left out: 6",
              "vertices merged with another at exactly the same position: 2",
              "triangles without area, kept as the segment or the point they span: 1", "the file has a remark"});
}

TEST_CASE("notes: a pair has notes about conversions and suspicious sizes only") {
  api::Comparison comparison;
  comparison.a.diagonal = comparison.b.diagonal = 3;
  CHECK(api::notes_of(comparison).empty());
  comparison.a.diagonal = 3 * 25.4 * 1.019;
  CHECK(
      api::notes_of(comparison) ==
      Notes{"mesh a is about 25.88 times as large as mesh b, as if mesh a were in millimetres and mesh b in inches: if "
            "so, declare the unit of each mesh"});
  comparison.a.diagonal = 3 * 25.4 * 1.021;
  CHECK(api::notes_of(comparison).empty());
  comparison.a.diagonal = 0;  // a point does not suggest a wrong unit
  CHECK(api::notes_of(comparison).empty());
  comparison.b.diagonal = 0;
  CHECK(api::notes_of(comparison).empty());

  const api::KnownUnit inches{api::LengthUnit::inch, api::UnitSource::declared};
  const api::KnownUnit millimetres{api::LengthUnit::millimeter, api::UnitSource::file};
  comparison.a.diagonal = 3;
  comparison.b.diagonal = 3 * 25.4;
  comparison.a.notes.unit = api::LengthUnit::meter;
  comparison.units = {inches, millimetres, millimetres};
  CHECK(api::notes_of(comparison) == Notes{"mesh a was taken to be in inches as declared, though its file is in metres",
                                           "mesh a was converted from inches to millimetres"});
  comparison.units = {millimetres, {}, {}};
  CHECK(api::notes_of(comparison)[0] ==
        "mesh a is in millimetres, the unit of mesh b is not known: the numbers were compared without conversion");
}

TEST_CASE("notes: a limit below ten times the deviation of splits gets a note in the unit of the result") {
  const api::KnownUnit inches{api::LengthUnit::inch, api::UnitSource::declared};
  const api::KnownUnit millimetres{api::LengthUnit::millimeter, api::UnitSource::declared};
  api::Comparison comparison;
  comparison.a.diagonal = comparison.b.diagonal = 3;
  comparison.b.notes.polygons.largest_deviation = 0.25;
  CHECK(api::notes_of(comparison).empty());
  comparison.options.max_distance = 2.5;
  CHECK(api::notes_of(comparison).empty());
  comparison.options.max_distance = 2;
  const std::string open =
      "mesh b has a face that is not planar and can be split into triangles that are up to 0.25 apart; the limit 2 is "
      "less "
      "than ten times that: the verdict may depend on how such a face is split";
  CHECK(api::notes_of(comparison) == Notes{open});
  comparison.options.max_distance = 100;
  comparison.options.zone = {3, 2};
  CHECK(api::notes_of(comparison) == Notes{open});
  comparison.options.max_distance = {};
  CHECK(api::notes_of(comparison) == Notes{open});
  comparison.options.zone = {};
  comparison.options.max_distance = 100;
  comparison.units = {millimetres, inches, millimetres};
  CHECK(api::notes_of(comparison).back().find("may depend on how") == std::string::npos);
  comparison.b.notes.polygons.largest_deviation = 10;  // 254 mm
  CHECK(api::notes_of(comparison).back().find("up to 254 mm apart; the limit 100 mm ") != std::string::npos);
}
