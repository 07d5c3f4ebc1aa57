// The part of a surface that lies in a region, or in none of several, as a mesh of its own.
//
// Statement. Let S be the exact surface, which the mesh stands for up to `error`, and P the closure of what S has in
// the region, or outside of all regions. A part consists of two meshes and e = PartMesh::error of each, such that
//   (sure)   each point of `sure` is within e of a point of P;
//   (cover)  each point of P is within e of a point of `sure` or of `doubtful`.
// The distance to another mesh is 1-Lipschitz, so for its supremum s over P
//   sup over sure - e <= s <= max(sup over sure + e, sup over doubtful + e).
//
// Proof. Each triangle is cut twice: an inner copy by half-spaces within the region, an outer copy by half-spaces
// that contain it. A corner carries the largest difference of each coordinate from the corner that it stands for: the
// corners of an inner triangle stand for those of one within P, those of the outer ones for triangles that cover P. A
// triangle is cut by numbers at its corners: f, the height above the plane, plus (inner) or minus (outer) what f may
// be off, at corners moved by their differences. Along a triangle both are affine, so that where the number is <= 0,
// the inner copy's f is, and the outer copy keeps every point whose f is. The new corner stands for the exact point
// at the same parameter of the edge (engine/rounding.h R15). Then e is the sum of the largest difference and of
// the gap, the largest distance of an outer corner from an inner one: the distance from a convex set has its maximum
// over a triangle at a corner. Outer triangles with a gap above `resolution` are doubtful.
//
// Box: its six half-spaces, inner and outer alike. A coordinate of a corner that was given, or that an axis-parallel
// edge or plane fixes, is exact, and so is its comparison: a surface in a face of the box is inside.
// Sphere: a piece within h of a point m is cut by the planes across n = (m - c) / |m - c|. |x - c| >= (x - c).n, so
// (x - c).n <= r contains the ball. x is at most h from the line through c and m, so (x - c).n <= sqrt(r^2 - h^2) is
// within it, for h <= r / 2. Pieces are halved until the gap is at most `resolution`, or the piece is.
// Outside: the same half-spaces reversed. A box leaves up to six convex parts.
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

// Pieces made of cut triangles, of one part: the others that a sphere's surface passes through are doubtful.
inline constexpr std::size_t kMostPieces = std::size_t{1} << 20;

struct PartMesh {
  Mesh mesh;                            // no triangle: empty
  std::vector<std::uint32_t> original;  // of each triangle: the given one that it is a part of
  double error = 0;
};

struct Part {
  PartMesh sure;
  PartMesh doubtful;
  bool whole = false;  // `sure` would be all of the given mesh: both meshes are left empty
};

enum class Keep { inside, outside };

// Returns the part of `mesh` inside of every region, or outside of all. nullopt: interrupted. `resolution` > 0: the
// largest gap of a piece that is not doubtful. At most kMostPieces pieces are made; then the rest is doubtful.
// Precondition: the mesh passes validate(), and stands for the exact surface up to `error`.
std::optional<Part> part_of(MeshView mesh, double error, std::span<const Region> regions, Keep keep, double resolution,
                            const Interrupted& interrupted);

}  // namespace meshgauge
