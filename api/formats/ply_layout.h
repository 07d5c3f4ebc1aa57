// Where the surface is among the elements of a PLY.
#pragma once

#include "api/formats/ply_header.h"

namespace meshgauge::api {

// Borrows from the header.
struct PlyLayout {
  const PlyElement* vertex = nullptr;          // has x, y and z, none of them a list
  const PlyProperty* face_corners = nullptr;   // list of integers of the element "face"; nullptr: there are no faces
  const PlyProperty* strip_corners = nullptr;  // the same of the element "tristrips"
};

// An Error when there is no element "vertex" with coordinates, or neither faces nor strips of it.
Result<PlyLayout> find_layout(const Source& source, const PlyHeader& header);

}  // namespace meshgauge::api
