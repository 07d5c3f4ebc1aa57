// Writes a deviation map as PLY, for MeshLab, CloudCompare, CGAL, Blender, three.js and other readers of PLY.
//
//   vertex   x y z          positions of the candidate: float if every coordinate is a float exactly, else double
//            nx ny nz       float, only where normals are asked for
//            red green blue uchar, sRGB (api/map/colour_map.h)
//            quality        float, the distance rounded to nearest, under the name that MeshLab reads
//            distance       double, the computed distance
//            signed_distance  double, with sides alone: DeviationMap::signed_distance()
//   face     vertex_indices uchar, uint
//
// Header comments describe the numbers, one fact each: limit, unit, certified interval, witness.
#pragma once

#include <ostream>

#include "api/map/deviation_map.h"

namespace meshgauge::api {

// Writes binary little-endian PLY. The caller checks the state of `out`.
void write_deviation_ply(const DeviationMap& map, std::ostream& out);

}  // namespace meshgauge::api
