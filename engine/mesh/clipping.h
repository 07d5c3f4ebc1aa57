// The part of a surface that lies in a region, or in none of several, as a mesh of its own.
//
// Statement. Let S be the exact surface, which the mesh stands for up to `error`, and P the closure of what S has in
// the region, or outside of all regions. A part consists of two meshes and e = PartMesh::error of each, such that
//   (sure)   each point of `sure` is within e of a point of P;
//   (cover)  each point of P is within e of a point of `sure` or of `doubtful`.
// The distance to another mesh is 1-Lipschitz, so for its supremum s over P
//   sup over sure - e <= s <= max(sup over sure + e, sup over doubtful + e).
//
// Proof. Each triangle is cut twice, as a convex polygon: an inner copy by half-spaces within the region, an outer copy
// by half-spaces that contain it. A corner carries the largest difference of each coordinate from the exact corner that
// it stands for: the exact inner polygon is within P, the exact outer ones cover P. A polygon is cut along its edges,
// at the zeros of a number g at its corners: the height f above the plane, plus (inner) or minus (outer) what f may be
// off. A new corner stands for the exact point at the same parameter of the exact edge (engine/rounding.h R15), so the
// exact polygon stays convex, and f, which is affine, is at most g (inner) or at least g (outer) at every corner, new
// ones included. Inner: each corner that is kept has g <= 0, so f <= 0 in their hull. Outer: what is cut off is the
// hull of corners with g > 0 and of the two ends of the cut with g = 0, so f >= 0 in it, and f = 0 only on the cut.
// That needs g <= 0 or g > 0 of corners that follow each other only. Where rounding makes g change its sign more than
// twice, the inner copy keeps one such run of corners, and the outer copy leaves out one. A triangle of the fan of a
// computed polygon stands for one of the exact polygon. Then e is the sum of the largest difference and of the gap
// between both copies, which is that of an outer corner: the distance from a convex set has its maximum over a polygon
// at a corner. Outer polygons with a gap above `resolution` are doubtful.
//
// Box: its six half-spaces, inner and outer alike. A coordinate of a corner that was given, or that an axis-parallel
// edge or plane fixes, is exact, and so is its comparison: a surface in a face of the box is inside.
// Sphere: a piece within h of a point m is cut by the planes across n = (m - c) / |m - c|. |x - c| >= (x - c).n, so
// (x - c).n <= r contains the ball. x is at most h from the line through c and m, so (x - c).n <= sqrt(r^2 - h^2) is
// within it, for h <= r / 2. Pieces are halved until the gap is at most `resolution`, or the piece is.
// Outside: the same half-spaces reversed. A box leaves up to six convex parts.
// Group: its triangles, uncut.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/region.h"

namespace meshgauge {

// Triangles made of cut ones, of one part: what a region's surface passes through after them is doubtful.
inline constexpr std::size_t kMostPieces = std::size_t{1} << 20;

struct PartMesh {
  Mesh mesh;                            // no triangle: empty
  std::vector<std::uint32_t> original;  // of each triangle: the given one that it is a part of
  double error = 0;
};

struct RegionPart {
  PartMesh sure;
  PartMesh doubtful;
  bool whole = false;  // `sure` would be all of the given mesh: both meshes are left empty
};

enum class Keep { inside, outside };

// Returns the part of `mesh` inside of every region, or outside of all. nullopt: interrupted. `resolution` > 0: the
// largest gap of a piece that is not doubtful. At most kMostPieces pieces are made; then the rest is doubtful.
// Preconditions: the mesh passes validate(), and stands for the exact surface up to `error`; groups are of this mesh.
std::optional<RegionPart> part_of(MeshView mesh, double error, std::span<const Region> regions, Keep keep,
                                  double resolution, const Interrupted& interrupted);

}  // namespace meshgauge
