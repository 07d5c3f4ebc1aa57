// Triangles cut by planes, with what rounding has moved of each corner: engine/clipping.h has the statement and proof.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "engine/mesh.h"

namespace meshgauge {

struct Corner {
  Vec3 at;
  Vec3 off;  // the largest difference of each coordinate from the corner that this one stands for

  // Upper bound of the length of `off`.
  double distance_off() const;
};

using Piece = std::array<Corner, 3>;

// The part of one triangle that satisfies some conditions, between an inner and an outer copy.
struct Pieces {
  std::vector<Piece> inner;
  std::vector<Piece> outer;
};

// Heights above a plane, positive on one side: n . (x - origin) - offset.
struct Plane {
  Vec3 normal;  // of length 1 up to rounding
  Vec3 origin;
  double offset = 0;
  int axis = -1;  // at least 0: the normal is exactly this axis or its reverse, and the offset is 0

  double height(const Vec3& x) const;
  // What the computed height of a corner may be off.
  double height_off(const Corner& corner) const;
};

// A half-space between two: {inner.height <= 0} within it within {outer.height <= 0}.
struct HalfSpace {
  Plane inner;
  Plane outer;
};

// Cuts both copies by the half-space.
Pieces within(const Pieces& pieces, const HalfSpace& half);
// Cuts both copies by the complement: the closure of what is not in the half-space.
Pieces beyond(const Pieces& pieces, const HalfSpace& half);
// Divides both copies: into triangles, or one triangle in two at its longest edge, if the copies are equal; else by a
// plane across the widest axis. Rounding is in `off` of the new corners.
std::vector<Pieces> divided(const Pieces& pieces);

// Upper bound of the distance of any point of `outer` from `inner`; infinite when only `inner` is empty, or when both
// have too many triangles to compare.
double gap(const Pieces& pieces);
// The largest distance_off() of both copies.
double distance_off(const Pieces& pieces);

// Returns |v| within a relative error of 8u.
double length_of(const Vec3& v);

}  // namespace meshgauge
