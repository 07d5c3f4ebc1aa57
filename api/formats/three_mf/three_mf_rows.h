// Reads the rows of a mesh in a 3MF, its <vertex> and <triangle> elements, from their bytes: several times as fast as
// by expat. Only the common form is read; expat reads everything else, and finds what is wrong with it.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "api/formats/three_mf/xml.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// Appends the vertices at the beginning of `text` to `positions` and returns their bytes. Stops before the first row
// that is not of the form <vertex x="1" y="-2.5e3" z=".5"/>, before one that is cut off, and at `most` positions. The
// common form: attributes in any order, each once, after white space; quotes of either kind; finite numbers as for
// read_coordinate(), without spaces around them. `text` begins behind a tag and ends with '>', or is empty. Takes
// time linear in the bytes that it returns and the first row that it does not.
XmlTaken take_mf_vertices(std::string_view text, std::size_t most, std::vector<Vec3>& positions);

// As above, for rows of the form <triangle v1="0" v2="1" v3="2"/> with indices below `vertices`. They may also have the
// attributes pid, p1, p2 and p3, and paint_color, paint_seam and paint_supports of slicers, which are not read.
XmlTaken take_mf_triangles(std::string_view text, std::size_t most, std::size_t vertices,
                           std::vector<Triangle>& triangles);

}  // namespace meshgauge::api
