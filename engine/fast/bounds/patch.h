// The patch certificate: all of B's triangles under many triangles of A, seen along one direction, cover them.
//
// Setting. pi projects along a direction, and z is the height along it. S is any set of triangles of B whose images are
// not degenerate and equally oriented. An edge of T in S is *open* unless exactly one other triangle of B shares it,
// that one is in S, and it runs along the edge in the opposite direction. P is a triangle of A.
//
// Statement. Fix phi >= u. N is the set of T in S for which pi(T) meets pi(P) and min |z_P - z_T| <= phi over the
// common part. If
//   (i)   max |z_P - z_T| <= u over pi(T) n pi(P), for every T in N,
//   (ii)  no open edge of a T in N meets pi(P),
//   (iii) an interior point of pi(P) lies in pi(T) for some T in N,
// then h(P, B) <= u.
// Proof. D, the interior of pi(P) without the images of vertices, is connected. C, the union of pi(T) over N, is
// closed. C n D is open in D: a point of it inside of some pi(T) has a neighbourhood in pi(T). A point on an edge of a
// T in N lies, by (ii), on the edge of a partner T' in S, whose image is beyond the edge, because both are equally
// oriented and run along it in opposite directions. The heights of both agree there, so |z_P - z_T'| <= u <= phi at the
// point, and T' is in N. By (iii) C n D is not empty, so D is in C, and because C is closed, pi(P) is. So over each x
// of P there is a point of a T in N at the height difference of at most u.
//
// Nothing is assumed about S as a whole. Where B has a border, a hole, a fold or an edge of three triangles, there is
// an open edge, and only the P over it fail. A sheet farther than phi is not in N. Triangles that are missing in S make
// open edges.
//
// Here phi = u = the limit that is asked for. z_P - z_T is linear, so its range over the common part is within those
// over the common box of the images, over the corners of T, and over the corners of P. If that is not enough, pi(T) n
// pi(P) is clipped and its corners give the range.
//
// Rounding (rounding.h R11). The frame maps each vertex to a rounded point; equal positions give equal points. These
// points are taken as exact, and pi drops their z: the statement holds for them unchanged. kPatchSlack covers the
// mapping. It remains that the decisions err to the safe side:
//  1. "Not degenerate and oriented so" errs to no: kPatchThinnest.
//  2. "Meets pi(P)" errs to yes. Boxes are compared exactly; polygons are clipped by half-planes moved outwards by
//     kPatchOffset; an edge misses pi(P) only if a side of pi(P) or the edge's own line separates them by that much.
//  3. "min |z_P - z_T| <= phi" errs to yes, and "max |z_P - z_T|" errs upwards, by the error that each triangle brings:
//     kPatchHeightError times its condition.
//  4. "Interior point of pi(P)" and "lies in pi(T)" err to no: kPatchNarrowest, and the sides of pi(T) are at least
//     kPatchOffset away.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/fast/bounds/polygon.h"
#include "engine/mesh/adjacency.h"
#include "engine/search/piece.h"
#include "engine/tree/bvh.h"

namespace meshgauge {

// One object for each thread.
class Patch {
 public:
  // What is known of a triangle of A.
  struct Bound {
    double upper = std::numeric_limits<double>::infinity();  // of h(triangle, B), slack included; infinite: failed
    std::uint32_t under = Nearest::kNone;                    // if bounded: a triangle of B under it
  };

  // `adjacency`: of the target's mesh. Both must outlive the object. `min_group`: Thresholds::patch_group.
  Patch(const Bvh& target, const Adjacency& adjacency, std::size_t min_group);

  // Tries to show for each of `triangles`, neighbours in `from`, that h(triangle, B) is at most `limit`. Returns a
  // bound for each, valid until the next call. Adds the number of triangles of B that were looked at to `work`.
  std::span<const Bound> attempt(MeshView from, std::span<const std::uint32_t> triangles, double limit, Work& work);

 private:
  // Triangles of A with similar normals, and the direction of their projection.
  struct Group {
    std::vector<std::size_t> members;  // places in `triangles`
    Vec3 direction;
    Box box;
  };
  // Eight triangles of B, consecutive in its order.
  struct Ground {
    PatchBlock block;
    std::uint32_t number = 0;           // of the leaf
    bool edges_known = false;           // `open` is known
    std::array<unsigned, 3> open = {};  // by edge: the lanes whose edge is open
  };
  // The box of the images of eight triangles.
  struct Extent {
    double low_x, high_x, low_y, high_y;
  };
  struct View;
  static constexpr std::size_t kMaxGrounds = 128;  // limit of the leaves of B under a group

  void take_normals(MeshView from, std::span<const std::uint32_t> triangles);
  bool next_group(MeshView from, std::span<const std::uint32_t> triangles);
  bool gather(double limit, Work& work);
  void leaves_within(const Box& box);
  static Extent extent_of(const PatchBlock& block);
  Orientations project_leaves(const PatchFrame& frame);
  void bound_group(MeshView from, std::span<const std::uint32_t> triangles, double limit, Work& work);
  static PatchPiece piece_of(const PatchBlock& block, std::size_t lane);
  Bound bound(const PatchPiece& piece, double limit, Work& work);
  void find_near(const PatchBlock& block);
  std::size_t find_hits(const PatchPiece& piece);
  static bool bound_by_clipping(const PatchPiece& piece, const Ground& ground, double limit, PatchCover& cover,
                                Bound& result);
  bool meets_open_edge(const PatchPiece& piece, Ground& ground, unsigned lanes);
  void find_open_edges(Ground& ground);
  bool is_open(std::uint32_t triangle, std::uint32_t edge) const;
  bool gathered(std::uint32_t triangle) const;

  const Bvh& target_;
  const Adjacency& adjacency_;
  const std::size_t min_group_;
  std::vector<Bound> bounds_;
  std::vector<Vec3> normals_;  // unit vectors; zero: none, or the triangle has been treated
  Group group_;
  PatchFrame frame_;
  bool mirrored_ = false;  // most of B's triangles were seen from behind
  std::vector<Ground> grounds_;
  std::size_t ground_size_ = 0;
  std::array<Extent, kMaxGrounds> extents_;     // by ground
  std::array<std::uint8_t, kMaxGrounds> near_;  // grounds under eight triangles of A
  std::size_t near_size_ = 0;
  std::array<std::uint8_t, kMaxGrounds> hits_;  // grounds under one of them
  std::vector<std::uint32_t> leaves_;
  std::vector<std::uint32_t> open_nodes_;
  std::uint64_t gatherings_ = 0;
  std::vector<std::uint64_t> gathered_;  // by leaf: number of the last gathering with it, and below the lanes in S
};

}  // namespace meshgauge
