// Reads the model parts of a 3MF package: objects, and where the build places them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "api/formats/file/affine_map.h"
#include "api/formats/file/source.h"
#include "api/formats/file/zip.h"

namespace meshgauge::api {

// A component of an object, or an item of the build.
struct MfPlacement {
  std::size_t part = 0;  // index into MfDocument::parts
  std::uint32_t object = 0;
  std::optional<AffineMap> transform;
  bool printed = true;  // false: an item marked as not printable
};

// What is not read of an object, by its kind as for Unread, which is shown only if the build places the object.
using MfUnread = std::map<std::string, std::size_t>;

// A mesh or components. The mesh is a range of the document's arrays; its triangles count its vertices from 0.
struct MfObject {
  std::size_t first_vertex = 0;
  std::size_t vertices = 0;
  std::size_t first_triangle = 0;
  std::size_t triangles = 0;
  std::vector<MfPlacement> components;
  std::string name;
  bool has_mesh = false;
  bool printed = true;  // by its type; only for a mesh, since each component has its own type
  bool steers = false;  // true: a setting of the slicer makes it a support or a modifier
  MfUnread unread;      // elements and attributes in it that are not known
};

using MfKey = std::pair<std::size_t, std::uint32_t>;  // part and id

struct MfDocument {
  std::vector<std::string> parts;  // entries of the archive; the first is the root model
  LengthUnit unit = LengthUnit::millimeter;
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  std::map<MfKey, MfObject> objects;
  std::vector<MfPlacement> build;
  MfUnread unread;                                // as those of objects, in the build
  std::size_t listed = 0;                         // number of objects, components and items, for their limit
  std::set<std::string, std::less<>> undeclared;  // the first kMostUndeclared prefixes without a declaration
  static constexpr std::size_t kMostUndeclared = 4;

  // Returns the index of a part in `parts`; appends a new one.
  std::size_t part_named(std::string_view name);

 private:
  std::map<std::string, std::size_t, std::less<>> numbers_;
};

// Reads the model of document.parts[part] and appends the parts that it names to `parts`. Understands the core of the
// standard and the extensions production (objects in other parts), materials and triangle sets. Refuses by name every
// other required extension, geometry of an extension that is not required, elements of the core namespace where the
// core has none of that name, and core geometry inside of an element that is not read. Counts elements of other
// namespaces in objects and in the build as unread. Errors also: too many vertices or triangles.
Result<Done> read_3mf_model(const Source& source, ZipArchive& archive, std::size_t part, MfDocument& document);

}  // namespace meshgauge::api
