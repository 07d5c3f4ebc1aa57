// A deviation map as GLB (glTF 2.0), for three.js, Blender, ParaView and browsers.
//
//   node "candidate"  one primitive of triangles: POSITION, COLOR_0, _DISTANCE, indices of 32 bits. No normals: readers
//                     shade it flat, as the standard has it. Its extras say what the numbers mean.
//   node "witness"    lines, without light: from the witness to the nearest point of the other mesh, and a cross there
//                     where it begins. Its own primitive, so that the candidate's counts are the mesh's.
//
//   POSITION   float, rounded to nearest. Where the mesh lies far from 0 on an axis, at least as far as it is wide,
//              both nodes are moved there instead (translation, exact in single precision), so that positions keep
//              the precision of the mesh's size, not of its offset: within 2^-24 of the size and 2^-48 of the offset.
//              Else the nodes do not move anything, and coordinates that are floats stay as they are.
//              They are the candidate's own: not turned so that y is up, as readers of glTF take it.
//   COLOR_0    unsigned short, normalised, RGBA; linear light, as the standard has it (api/colour_map.h is sRGB)
//   _DISTANCE  float, rounded to nearest, of what was computed
//
//   extras of "candidate"
//   limit | largest          what the last colour stands for: a limit, or the largest distance of a vertex
//   units                    label, may be empty
//   lower, upper, witness    the certified interval of the comparison, and where `lower` is attained: on the candidate
//                            or, without from_candidate, on the baseline; null: there is no upper bound
//   direction                the same of the way from the candidate to the baseline alone, where that was measured
//   display                  form: as_is, refined or decimated; vertices and triangles of the candidate itself
//   candidate_vertices, candidate_triangles: the same numbers; of a map that is not decimated these vertices come first
#pragma once

#include <ostream>

#include "api/deviation_map.h"
#include "engine/result.h"

namespace meshgauge::api {

// too_large: more than the 4 GiB of a GLB, or numbers beyond what a float holds. Whether it could be written, `out`
// says. Takes twice the size of the file in memory.
Result<Done> write_deviation_glb(const DeviationMap& map, std::ostream& out);

// How large such a file is, but for a few thousand bytes.
std::size_t glb_bytes(std::size_t vertices, std::size_t triangles);

}  // namespace meshgauge::api
