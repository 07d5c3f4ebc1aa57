#include "api/formats/ply_layout.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>

#include "api/formats/text.h"

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

bool is_one_of(std::string_view name, std::span<const std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

bool has_one_of(std::string_view name, std::span<const std::string_view> words) {
  return std::ranges::any_of(words,
                             [name](std::string_view word) { return name.find(word) != std::string_view::npos; });
}

bool are_lines(const PlyElement& element) {
  constexpr std::string_view kNames[] = {"edge", "edges", "line", "lines", "polyline", "polylines"};
  return is_one_of(lower_case(element.name), kNames);
}

bool is_attribute(const PlyProperty& property) {
  constexpr std::string_view kWords[] = {"tex", "uv", "normal", "color", "colour", "material"};
  std::string name = lower_case(property.name.substr(0, 64));                           // names have any length
  while (name.find("vertex") != std::string::npos) name.erase(name.find("vertex"), 6);  // has "tex"
  return has_one_of(name, kWords);
}

// Whether a property is one vertex of several: "v1", "vertex2".
bool is_corner(const PlyProperty& property) {
  if (property.is_list || !is_integer(property.type) || property.name.empty() || !is_digit(property.name.back())) {
    return false;
  }
  const std::size_t letters = property.name.find_first_of("0123456789");
  return is_one_of(lower_case(property.name.substr(0, letters)),
                   std::array<std::string_view, 3>{"v", "vertex", "vertex_"});
}

// Whether a property may be one vertex of several under any name. A byte is a colour.
bool may_be_corner(const PlyProperty& property) {
  return is_corner(property) || (!property.is_list && is_integer(property.type) && size_of(property.type) > 1);
}

// Whether an element that is not read may be surface: because of a list that may hold corners or points, or of three
// properties that may be corners.
bool may_be_surface(const PlyElement& element) {
  constexpr std::string_view kNeverSurface[] = {"camera", "cameras", "material", "materials", "texture", "textures"};
  const std::string name = lower_case(element.name);
  if (element.properties.empty() || is_one_of(name, kNeverSurface) || are_lines(element)) return false;
  const auto holds_points = [](const PlyProperty& property) { return property.is_list && !is_attribute(property); };
  return std::ranges::any_of(element.properties, holds_points) ||
         std::ranges::count_if(element.properties, may_be_corner) >= 3;
}

}  // namespace

bool may_hold_corners(const PlyProperty& property) {
  return property.is_list && is_integer(property.type) && !is_attribute(property);
}

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
  layout.only_points = true;
  for (const PlyElement& element : header.elements) {
    if (&element == layout.vertex || &element == face || &element == strip) continue;
    if (element.count == 0 && std::ranges::none_of(element.properties, &PlyProperty::is_list)) continue;
    const bool lines = are_lines(element), surface = may_be_surface(element);
    layout.only_points = layout.only_points && !lines && !surface;
    if (lines && !element.properties.empty()) layout.lines += element.count;
    if (surface && element.count > 0) layout.unread.add("elements " + in_quotes(element.name), element.count);
  }
  if (face != nullptr || strip != nullptr || layout.only_points || !layout.unread.empty()) return layout;
  return header_error(source, ErrorCode::empty_mesh, "neither an element 'face' nor 'tristrips', so no triangles");
}

}  // namespace meshgauge::api
