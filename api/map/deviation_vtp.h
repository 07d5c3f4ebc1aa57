// Writes a deviation map as VTP, VTK's XML of polygons, for ParaView and PyVista: version 1.0, little-endian, its
// arrays raw behind the XML. Lengths are doubles.
//
//   Points, Polys    the mesh shown; Verts instead of Polys for a cloud
//   distance         of each point, the computed distance
//   signed_distance  with sides alone: DeviationMap::signed_distance()
//   Normals          where they are asked for
//   field data       limit | largest, lower, upper (not when it is infinite) and no_sides: as in
//   api/map/deviation_glb.h
#pragma once

#include <ostream>

#include "api/map/deviation_map.h"

namespace meshgauge::api {

// The caller checks the state of `out`.
void write_deviation_vtp(const DeviationMap& map, std::ostream& out);

}  // namespace meshgauge::api
