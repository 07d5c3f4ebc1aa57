#include "api/formats/ply_layout.h"

#include <algorithm>

namespace meshgauge::api {
namespace {

const PlyElement* find_element(const PlyHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

const PlyProperty* find_property(const PlyElement& element, std::string_view name) {
  const auto found = std::ranges::find(element.properties, name, &PlyProperty::name);
  return found == element.properties.end() ? nullptr : &*found;
}

Error header_error(const Source& source, ErrorCode code, const std::string& what) {
  return at(source, "the PLY header", code, what);
}

Result<Done> check_coordinates(const Source& source, const PlyElement& vertex) {
  for (const std::string name : {"x", "y", "z"}) {
    const PlyProperty* property = find_property(vertex, name);
    if (property == nullptr) {
      return header_error(source, ErrorCode::unreadable_mesh, "element 'vertex' has no property '" + name + "'");
    }
    if (property->is_list) {
      return header_error(source, ErrorCode::unreadable_mesh, "property '" + name + "' is a list");
    }
  }
  return Done{};
}

// Returns the list of corners of an element; nullptr: no such element.
Result<const PlyProperty*> find_corners(const Source& source, const PlyElement* element, const std::string& name) {
  if (element == nullptr) return nullptr;
  const PlyProperty* corners = find_property(*element, "vertex_indices");
  if (corners == nullptr) corners = find_property(*element, "vertex_index");
  if (corners == nullptr || !corners->is_list) {
    return header_error(source, ErrorCode::unreadable_mesh, "element '" + name + "' has no list 'vertex_indices'");
  }
  if (!is_integer(corners->type)) {
    return header_error(source, ErrorCode::unreadable_mesh, "'" + corners->name + "' is not of an integer type");
  }
  return corners;
}

// Whether an element may join vertices: by a list, such as faces under a name that is not known, or as edges.
bool may_join(const PlyElement& element) {
  return element.name == "edge" || std::ranges::any_of(element.properties, &PlyProperty::is_list);
}

}  // namespace

Result<PlyLayout> find_layout(const Source& source, const PlyHeader& header) {
  PlyLayout layout;
  layout.vertex = find_element(header, "vertex");
  if (layout.vertex == nullptr) return header_error(source, ErrorCode::empty_mesh, "no element 'vertex'");
  if (auto ok = check_coordinates(source, *layout.vertex); !ok) return std::move(ok).error();
  const PlyElement *face = find_element(header, "face"), *strip = find_element(header, "tristrips");
  const auto faces = find_corners(source, face, "face");
  if (!faces) return faces.error();
  const auto strips = find_corners(source, strip, "tristrips");
  if (!strips) return strips.error();
  layout.face_corners = *faces;
  layout.strip_corners = *strips;
  layout.only_points = std::ranges::none_of(header.elements, [&](const PlyElement& element) {
    return &element != layout.vertex && &element != face && &element != strip && may_join(element);
  });
  if (face != nullptr || strip != nullptr || layout.only_points) return layout;
  return header_error(source, ErrorCode::empty_mesh, "neither an element 'face' nor 'tristrips', so no triangles");
}

}  // namespace meshgauge::api
