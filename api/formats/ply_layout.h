// Finds the surface among the elements of a PLY.
#pragma once

#include "api/formats/ply_header.h"

namespace meshgauge::api {

// Borrows from the header.
struct PlyLayout {
  const PlyElement* vertex = nullptr;          // has scalars x, y and z
  const PlyProperty* face_corners = nullptr;   // list of integers in the element "face"; nullptr: no faces
  const PlyProperty* strip_corners = nullptr;  // list of integers in the element "tristrips"; nullptr: no strips
  bool only_points = false;                    // no element that may join vertices, but faces and strips
  std::size_t lines = 0;                       // in elements of edges and lines
  Unread unread;                               // elements that may be surface, under other names
};

// Whether a property of faces or strips, other than their corners, may be part of the surface: a list of integers whose
// name has nothing of normals, textures, colours or materials. Such a list may hold corners, of holes for example.
bool may_hold_corners(const PlyProperty& property);

// Returns the layout. Error: no element "vertex" with coordinates, or neither triangles, nor points alone, nor what may
// be surface and is not read.
Result<PlyLayout> find_layout(const Source& source, const PlyHeader& header);

}  // namespace meshgauge::api
