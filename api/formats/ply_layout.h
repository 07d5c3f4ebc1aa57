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
};

// Returns the layout. Error: no element "vertex" with coordinates, or neither triangles nor points alone.
Result<PlyLayout> find_layout(const Source& source, const PlyHeader& header);

}  // namespace meshgauge::api
