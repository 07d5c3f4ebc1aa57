// A deviation map as PLY, for MeshLab, CloudCompare, CGAL, Blender, three.js and whatever reads PLY.
//
//   vertex   x y z          float if every coordinate is one exactly, else double: the candidate's own positions
//            red green blue uchar, sRGB: api/colour_map.h
//            quality        float, rounded to nearest: the name that MeshLab looks for; it works in single precision
//            distance       double, exactly what was computed
//   face     vertex_indices uchar, uint
//
// What the numbers mean stands in comments, one fact each: limit, unit, certified interval, witness.
#pragma once

#include <ostream>

#include "api/deviation_map.h"

namespace meshgauge::api {

// Binary, little-endian. Whether it could be written, `out` says.
void write_deviation_ply(const DeviationMap& map, std::ostream& out);

}  // namespace meshgauge::api
