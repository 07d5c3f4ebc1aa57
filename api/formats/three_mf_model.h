// The model parts of a 3MF package: objects, and which of them the build shows where.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "api/formats/source.h"
#include "api/formats/zip.h"

namespace meshgauge::api {

// A component of an object, or an item of the build.
struct MfPlacement {
  std::size_t part = 0;  // of MfDocument::parts
  std::uint32_t object = 0;
  std::optional<Eigen::Affine3d> transform;
  bool printed = true;  // false: an item that the slicer is told to leave out
};

// A mesh, or components; the arrays are those of the document, its triangles count their vertices from 0.
struct MfObject {
  std::size_t first_vertex = 0;
  std::size_t vertices = 0;
  std::size_t first_triangle = 0;
  std::size_t triangles = 0;
  std::vector<MfPlacement> components;
  bool has_mesh = false;
  bool printed = true;  // by its type, which counts for a mesh only: of components each has its own
  bool steers = false;  // a setting of the slicer makes it support, or a modifier
};

using MfKey = std::pair<std::size_t, std::uint32_t>;  // part and id

struct MfDocument {
  std::vector<std::string> parts;  // entries of the archive; the first is the root model
  LengthUnit unit = LengthUnit::millimeter;
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  std::map<MfKey, MfObject> objects;
  std::vector<MfPlacement> build;
  std::size_t listed = 0;  // objects, components and items, which are limited

  // The number of a part, new or known.
  std::size_t part_named(std::string_view name);

 private:
  std::map<std::string, std::size_t, std::less<>> numbers_;
};

// Reads the model of document.parts[part]; those it names are appended to `parts`. Understood are the core of the
// standard and, of its extensions, production (objects in other parts), materials and triangle sets. Refused by name:
// every other required extension, and geometry of an extension that is not required. Vertices and triangles are
// limited.
Result<Done> read_3mf_model(const Source& source, ZipArchive& archive, std::size_t part, MfDocument& document);

// As in a relationship or a path: without the leading slash of an absolute name.
std::string_view part_name(std::string_view path);

}  // namespace meshgauge::api
