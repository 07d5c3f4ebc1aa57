// Writes a deviation map as GLB (glTF 2.0), for three.js, Blender, ParaView and browsers.
//
//   node "candidate"  one primitive of triangles: POSITION, COLOR_0, _DISTANCE, 32-bit indices. NORMAL only where it is
//                     asked for: without, readers shade it flat, as glTF 2.0 requires. Its extras describe the numbers.
//   node "witness"    unlit lines: from the witness to the nearest point of the other mesh, and a cross at the witness.
//                     A primitive of its own, so that the candidate's counts are the mesh's.
//
//   POSITION   float, rounded to nearest. On each axis where the mesh is at least as far from 0 as its box is wide,
//              both nodes have a translation (exact in single precision), and positions are relative to it, so that
//              they keep the precision of the mesh's size: within 2^-24 of the size and 2^-48 of the offset.
//              Otherwise there is no translation, and coordinates that are floats are unchanged.
//              The axes are the candidate's own: not rotated to glTF's y-up.
//   COLOR_0    unsigned short, normalised, RGBA; linear light as glTF 2.0 requires (api/map/colour_map.h is sRGB)
//   _DISTANCE  float, the computed distance rounded to nearest
//   _SIDE      float, with sides alone: 1 outside of the baseline, -1 inside, 0 where neither is proved, since glTF has
//              no NaN; the signed distance is the product of both
//
//   extras of "candidate"
//   limit | largest          distance of the last colour: a limit, or the largest distance of a vertex
//   no_sides                 why there is no _SIDE, where it was asked for
//   units                    unit's name, may be empty
//   lower, upper             certified interval of the comparison; upper null: there is no upper bound
//   witness                  where `lower` is attained; from_candidate: true: from the candidate, false: from the other
//   direction                interval and witness from the candidate to the baseline only, if that was measured
//   display                  form: as_is, refined or decimated; vertices and triangles of the candidate itself
//   candidate_vertices, candidate_triangles: the same counts; unless decimated, the candidate's vertices come first
#pragma once

#include <cstdint>
#include <ostream>

#include "api/map/deviation_map.h"
#include "engine/result.h"

namespace meshgauge::api {

// Writes the map; takes twice the file's size of memory. The caller checks the state of `out`. Error: too_large for
// more than the 4 GiB of a GLB or numbers beyond single precision.
Result<Done> write_deviation_glb(const DeviationMap& map, std::ostream& out);

// Estimates the size of the file in bytes, to within a few thousand.
std::uint64_t glb_bytes(std::uint64_t vertices, std::uint64_t triangles, bool sides = false, bool normals = false);

}  // namespace meshgauge::api
